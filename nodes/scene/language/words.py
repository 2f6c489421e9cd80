"""Reader of the words in a phrase, one after the other; errors have their column in the phrase."""

import re

from heavylift.nodes.scene.text.expressions import QUANTITY, UNIT
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.spelling import NUMBER, Reader
from heavylift.nodes.scene.text.units import Dimension

from .phrases import PhraseError

_PUNCTUATED = re.compile(rf"\d+(?:[:,]\d+)+(?:\.\d+)?(?:\s*(?:{UNIT})(?![\w/%]))?")  # reported by the dimension
_KNOWN = re.compile(rf"{NUMBER}\s*(?:{UNIT})?(?![\w/%])")
_UNKNOWN = re.compile(rf"{NUMBER}\s*[^\s\[\],<>=]*")  # with a unit that is none
LONGEST = 10_000  # characters of a phrase
_TOKEN = re.compile(r">=|<=|==|=|>|<|[\[\],]|[^\s\[\],<>=]+")


class PhraseReader(Reader):
    """Parser of a phrase, which reads it word by word from left to right."""

    def __init__(self, text: str) -> None:
        super().__init__(text)
        if len(text) > LONGEST:
            raise self.error(f"a phrase has at most {LONGEST} characters, this one has {len(text)}")

    @property
    def next(self) -> str:
        match = _TOKEN.match(self.text, self.at)
        return match[0] if match else ""

    def take(self, *words: str) -> str:
        """Read and return the next word if it is one of `words`; else return ""."""
        word = self.next
        if word not in words:
            return ""
        self.move(self.at + len(word))
        return word

    def expect(self, *words: str, after: str) -> str:
        found = self.take(*words)
        if not found:
            wanted = " or ".join(f"'{w}'" for w in words)
            raise self.error(f"{after} {wanted} must follow, not {self._found()}", closest(self.next, words))
        return found

    def name(self, what: str) -> str:
        word = self.next
        if not word or not (word[0].isalnum() or word[0] == "_"):
            raise self.error(f"{what} is expected here, not {self._found()}")
        self.move(self.at + len(word))
        return word

    def quantity(self, dimension: Dimension) -> float:
        """Read a number with a unit of this dimension and return it in SI units."""
        found = next((x for form in (_PUNCTUATED, _KNOWN, _UNKNOWN) if (x := form.match(self.text, self.at))), None)
        text = found[0] if found else self.next
        if not text:
            raise self.error(f"the phrase ends where {dimension.article} is expected")
        try:
            number = dimension.read(text)
        except ValueError as error:
            raise self.error(str(error)) from None
        self.move(self.at + len(text))
        return number

    @property
    def turning(self) -> bool:
        """Whether the next quantity in the phrase has a unit of angle."""
        return self._unit.startswith(("deg", "rad"))

    @property
    def share(self) -> bool:
        """Whether the next quantity in the phrase is in per cent."""
        return self._unit == "%"

    @property
    def _unit(self) -> str:
        found = QUANTITY.match(self.text, self.at)
        return found["unit"] or "" if found else ""

    def positive(self, dimension: Dimension) -> float:
        at = self.at
        number = self.quantity(dimension)
        if number <= 0:
            message = f"{dimension.article} must be greater than zero: the verb says the direction"
            raise PhraseError(message, "", at)
        return number

    def end(self) -> None:
        if self.at < len(self.text):
            raise self.error(f"the phrase is complete before {self._found()}; remove the rest")

    def error(self, sentence: str, hint: str = "") -> PhraseError:
        return PhraseError(sentence, hint, self.at)

    def _found(self) -> str:
        return f"'{self.next}'" if self.next else "the end of the phrase"
