"""Reading of typed values from a yard file and of cells from its tables; errors are reported at their places."""

from collections.abc import Callable
from pathlib import Path as FilePath
from re import fullmatch
from typing import Any, TypeVar, cast

from heavylift.kernel.errors import SceneError, closest
from heavylift.nodes.scene.text.source import Data, Mark, Path, SourceText
from heavylift.nodes.scene.text.table_files import TableCell, TableColumn, table

NAME = r"[A-Za-z0-9_-]+"
T = TypeVar("T")


class Taking:
    """Parser of typed values from the data of a file; it collects the errors."""

    def __init__(self, source: SourceText) -> None:
        self.source = source

    def take(self, path: Path, of: Callable[[Any], T], usual: Any, mark: Mark | None = None, value: Data = None) -> T:
        """Return the value at a path, converted by `of`; if it is missing or invalid, return the default `usual`."""
        value = self.source.at(path) if value is None else value
        if value is None:
            return cast(T, usual)
        try:
            return of(value)
        except (ValueError, SceneError) as error:
            self.source.fault(path, str(error), mark=mark)
            return cast(T, usual)

    def cell(self, cells: dict[str, TableCell], column: str, at: Path, of: Callable[[str], T], usual: Any) -> T:
        """Return the cell in a column, converted by `of`; if it is missing or invalid, return the default `usual`."""
        found = cells.get(column)
        return self.take((*at, column), of, usual, found.mark, found.text) if found else cast(T, usual)

    def mapping(self, path: Path, known: set[str] | None = None) -> dict[str, Data]:
        """Return the mapping at a path; add errors for keys that are not in `known`."""
        found = self.source.at(path)
        if found is not None and not isinstance(found, dict):
            self.source.fault(path, "write a mapping of keys here")
        given = found if isinstance(found, dict) else {}
        for key in given:
            if known is not None and key not in known:
                self.source.fault((*path, key), "this key is not known here", closest(key, sorted(known)), on_key=True)
            elif known is None and not fullmatch(NAME, key):
                self.source.fault((*path, key), "a name has letters, digits, _ and - only", on_key=True)
        return given

    def known(self, path: Path, word: Data, among: Any, what: str) -> None:
        """Add an error unless a word is one of the known names."""
        if word not in among:
            self.source.fault(path, f"there is no {what} '{word}'", closest(str(word), [x for x in among if x]))

    def table(self, path: Path, root: FilePath | None = None) -> tuple[list[TableColumn], list[list[TableCell]]]:
        """Return the column heads and rows of the table file that a value of the data names; empty after an error.

        `root`: its folder (default: that of the yard file)."""
        try:
            found = table(root or self.source.root, str(self.source.at(path)))
            return found.head, found.rows
        except (SceneError, ValueError) as error:
            self.source.fault(path, str(error))
            return [], []
