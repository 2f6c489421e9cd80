"""Error messages of a scene in a format that editors can jump to: `file:line:col: error: path: sentence`.

Below each message is the source line with a caret and, if a name is similar to a known one, a suggestion. All errors of
a scene are reported together, in the order of the text.
"""

from collections.abc import Iterable

from heavylift.kernel.errors import PlacedFault, SceneError, closest as closest

from .source import Fault, Mark, Path, SourceText, shown

MOST = 200  # errors that are reported at once
WIDEST = 400  # characters of a line that are shown


def raise_faults(source: SourceText, faults: Iterable[Fault]) -> None:
    """Raise one SceneError with the text of all faults (errors with their places), if there are any."""
    marked = sorted(((_mark(source, fault), fault) for fault in faults), key=lambda x: _order(source, x[0]))
    texts = list(dict.fromkeys(_text(mark, fault, source.written(fault.path)) for mark, fault in marked[:MOST]))
    if texts:
        number = f"more than {MOST}" if len(marked) > MOST else f"{len(texts)}"
        count = f"{number} error{'' if number == '1' else 's'} in {source.name}"
        error = SceneError("\n".join([*texts, count]))
        error.faults = tuple(dict.fromkeys(_placed(source, mark, fault) for mark, fault in marked[:MOST]))
        raise error


def _placed(source: SourceText, mark: Mark, fault: Fault) -> PlacedFault:
    path = shown(source.written(fault.path))
    return PlacedFault(mark.file, mark.line, mark.column, path, fault.sentence, fault.hint)


def _mark(source: SourceText, fault: Fault) -> Mark:
    found = fault.mark or source.mark(fault.path, on_key=fault.on_key)
    return Mark(found.file, found.line, found.column + fault.column, found.text)


def _order(source: SourceText, mark: Mark) -> tuple[bool, str, int, int]:
    return (mark.file != source.name, mark.file, mark.line, mark.column)


def _text(mark: Mark, fault: Fault, path: Path) -> str:
    start = max(0, mark.column - WIDEST // 2) if len(mark.text) > WIDEST else 0
    text, column = mark.text[start : start + WIDEST], mark.column - start  # what stands around the place
    gutter = f"{mark.line:5d} | "
    blank = "".join("\t" if c == "\t" else " " for c in text[: column - 1]).ljust(column - 1)
    caret = f"{' ' * (len(gutter) - 2)}| {blank}^{' ' + fault.hint if fault.hint else ''}"
    head = f"{mark.file}:{mark.line}:{mark.column}: error: {shown(path)}: {fault.sentence}"
    return f"{head}\n{gutter}{text}\n{caret}"
