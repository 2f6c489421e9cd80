"""Named values of a scene or machine type, which may be expressions of one another, and values `=...` that use them."""

from collections.abc import Mapping

from .expressions import ExpressionError, Value, evaluated, shown_as, value_of
from .source import Data, Path, SourceText, mapped

AXES = {"x": 0, "y": 1, "z": 2}


class Parameters:
    """Parameters of a scene or machine type, whose values may be expressions of other parameters.

    The values in `given` override those in `values`."""

    def __init__(self, values: Mapping[str, Data], given: Mapping[str, Data]) -> None:
        self.values, self.given = values, given
        self._known: dict[str, Value | None] = {}
        self._busy: list[str] = []

    def raw(self, name: str) -> Data:
        """Return the value of a parameter as written, which may be an expression."""
        return self.given.get(name, self.values[name])

    def computed(self, text: str) -> Data:
        """Return the result of an expression, given without its `=`; words, lists and places stay as they are."""
        name = " ".join(text.split())
        if name in self.values:
            raw = self.raw(name)
            if value_of(raw) is None and not _computed(raw):
                return raw  # a word, a list or a place
        return shown_as(evaluated(text, self.value))

    def value(self, word: str) -> Value | None:
        """Return the value of a parameter, or of one coordinate of a place (`lug.x`); None for any other word."""
        if word not in self._known:
            name, _, axis = word.rpartition(".")
            whole = word if word in self.values else name
            if whole not in self.values:
                return None
            if whole in self._busy:
                raise ExpressionError(f"the parameter '{whole}' depends on itself; give it a value without itself")
            raw = self.raw(whole)
            if whole != word:
                raw = raw[AXES[axis]] if isinstance(raw, list) and len(raw) == len(AXES) else None
            self._busy.append(whole)
            ours = _computed(raw) and whole not in self.given
            self._known[word] = evaluated(str(raw)[1:], self.value) if ours else value_of(raw)
            self._busy.pop()
        return self._known[word]


def arithmetic(source: SourceText) -> bool:
    """Replace each value `=...` in a scene by the result of the expression; errors are added to the scene.

    The scene's `parameters` are used (machine types have parameters of their own). Return whether all expressions could
    be computed."""
    named = source.data.get("parameters")
    parameters, done = Parameters(named if isinstance(named, dict) else {}, {}), True

    def made(data: Data, path: Path) -> Data:
        nonlocal done
        if path[0] == "types" or not _computed(data):
            return data
        text = str(data)[1:]
        try:
            return parameters.computed(text)
        except ExpressionError as error:
            source.fault(path, str(error), column=1 + max(error.column, len(text) - len(text.lstrip())))
            done = False
            return None

    source.data = mapped(source.data, made)
    return done


def _computed(data: Data) -> bool:
    return isinstance(data, str) and data.startswith("=")
