"""The page about Python as a notebook: `python tests/pages/notebook.py` writes coordinator/run/PYTHON.ipynb.

Code and what it prints are those of the page, which its test follows; a console block becomes a cell of the shell.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE, NOTEBOOK = ROOT / "coordinator/run/PYTHON.md", ROOT / "coordinator/run/PYTHON.ipynb"
BLOCK = re.compile(r"```(python|sh|text)\n(.*?)```\n", re.DOTALL)


def notebook(page: str) -> str:
    """A notebook of format 4.5 of a page."""
    cells: list[dict[str, object]] = []

    def cell(kind: str, text: str, **more: object) -> None:
        source = text.strip("\n").splitlines(keepends=True)
        if source:
            cells.append({"cell_type": kind, "id": f"cell-{len(cells)}", "metadata": {}, "source": source, **more})

    end = 0
    for block in BLOCK.finditer(page):
        cell("markdown", page[end : block.start()])
        end = block.end()
        kind, text = block[1], block[2]
        if kind == "text":
            cells[-1]["outputs"] = [{"output_type": "stream", "name": "stdout", "text": text.splitlines(keepends=True)}]
        else:
            cell("code", f"%%sh\n{text}" if kind == "sh" else text, execution_count=None, outputs=[])
    cell("markdown", page[end:])
    about = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}}
    return json.dumps({"cells": cells, "metadata": about, "nbformat": 4, "nbformat_minor": 5}, indent=1) + "\n"


if __name__ == "__main__":
    NOTEBOOK.write_text(notebook(PAGE.read_text()))
    print(f"wrote {NOTEBOOK.relative_to(ROOT)}")
