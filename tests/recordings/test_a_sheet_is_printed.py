"""A sheet says the same as text, page, workbook and plain data, whatever stands in it."""

from __future__ import annotations

import io
from html import unescape
from html.parser import HTMLParser

import pytest
from heavylift.recordings.sheets import (
    CLOCK,
    Chart,
    Column,
    Marked,
    Notes,
    Sheet,
    Table,
    data_of,
    page_of,
    plain,
    table_csv,
    text_of,
    trimmed,
    workbook_of,
)
from hypothesis import given, settings, strategies as st

WORDS = st.text(st.characters(codec="ascii", categories=("L", "N", "P", "Zs")), min_size=1, max_size=12)
NUMBERS = st.floats(-1e6, 1e6)
COLUMNS = st.one_of(
    st.builds(Column, WORDS),
    st.builds(Column, WORDS, st.sampled_from(["kN", "t", "%", "deg"]), st.integers(0, 3)),
    st.builds(Column, WORDS, st.just(CLOCK)),
)


@st.composite
def tables(draw: st.DrawFn) -> Table:
    columns = tuple(draw(st.lists(COLUMNS, min_size=1, max_size=5)))
    cells = [st.one_of(st.none(), NUMBERS.map(abs)) if column.numeric else WORDS for column in columns]
    rows = draw(st.lists(st.tuples(*cells), min_size=1, max_size=4))
    marked = draw(st.booleans())
    shown = [(Marked(row[0]), *row[1:]) if marked else row for row in rows]
    return Table(draw(WORDS), columns, tuple(shown), tuple(draw(st.lists(WORDS, max_size=2))))


class Cells(HTMLParser):
    """The texts of all cells of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []
        self._inside = False

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self._inside = tag in ("td", "th")
        self.found += [""] if self._inside else []

    def handle_endtag(self, tag: str) -> None:
        self._inside = False

    def handle_data(self, data: str) -> None:
        if self._inside:
            self.found[-1] += data


@settings(max_examples=60, deadline=None)
@given(tables())
def test_a_sheet_of_results_has_the_same_cells_in_every_output_format(table: Table) -> None:
    from openpyxl import load_workbook

    sheet = Sheet("title", "lead", "red", (table, Notes("notes", ("a <b>note",)), Chart("chart", "<svg></svg>")))
    texts = [column.text(cell) for row in table.rows for column, cell in zip(table.columns, row, strict=True)]
    cells = Cells()
    cells.feed(page_of(sheet))
    assert cells.found == [column.heading for column in table.columns] + texts
    assert all(text.strip() in text_of(sheet) for text in texts)
    known = [[plain(x) for x in row] for row in table.rows]
    assert data_of(sheet)["tables"][0]["rows"] == known
    (leaf,) = load_workbook(io.BytesIO(workbook_of(sheet))).worksheets
    head, *rows = list(leaf.values)[3 : 4 + len(table.rows)]
    assert head == tuple(column.heading for column in table.columns)
    for row, shown in zip(known, rows, strict=True):
        for column, cell, value in zip(table.columns, row, shown, strict=True):
            if cell is not None and column.unit == CLOCK:
                assert value.total_seconds() == pytest.approx(cell, abs=1e-3)
            else:
                assert value == (pytest.approx(cell) if column.numeric and cell is not None else cell)


def test_text_from_scenes_is_escaped_in_every_format_of_a_sheet() -> None:
    """No formula in a workbook or CSV, no tag on a page."""
    from openpyxl import load_workbook

    nasty = Table("=a/b*c?[d]" * 5, (Column("=1+1"),), (("=1+1",), ("<script>",), ("\x00",)), ("=2+2",))
    sheet = Sheet("=3+3", "<b>", "", (nasty, nasty))
    book = load_workbook(io.BytesIO(workbook_of(sheet)))
    assert len({leaf.title for leaf in book.worksheets}) == 2
    kinds = {cell.data_type for leaf in book.worksheets for row in leaf.iter_rows() for cell in row if cell.value}
    assert kinds == {"s"}
    assert "<script>" not in page_of(sheet)
    assert unescape(page_of(sheet)).count("<script>") == 2
    assert not any(line.startswith("=") for line in table_csv(nasty).splitlines())


def test_a_sheet_of_results_omits_empty_columns() -> None:
    made = Table("", (Column("a"), Column("b", "t"), Column("c", "t")), (("x", None, 0.0), ("y", None, None)))
    assert [column.name for column in trimmed(made).columns] == ["a", "c"]
    assert trimmed(made).rows == (("x", 0.0), ("y", None))


def test_a_sheet_of_results_states_infinite_values_in_words() -> None:
    column = Column("use", "%", 1)
    shown = [column.text(x) for x in (float("inf"), float("nan"), -0.04, Marked(99.96))]
    assert shown == ["beyond any", "", "0.0", "100.0"]
