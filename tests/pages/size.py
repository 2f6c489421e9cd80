"""Counts sizes of the project: `python tests/pages/size.py` prints the counts and fails above their limits.

Words of pages are counted as `wc -w` does; the reference, which the site generates, is not among them.
"""

from __future__ import annotations

import ast
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from page_blocks import ROOT
from test_every_folder_is_packaged import ROOMS

README_WORDS, PAGES_WORDS = 600, 42_000


def files(ending: str) -> list[Path]:
    """Files of the repository with an ending, sorted."""
    listed = subprocess.run(
        ["git", "-C", str(ROOT), "ls-files", f"*{ending}"], check=True, capture_output=True, text=True
    )
    return [path for name in listed.stdout.splitlines() if (path := ROOT / name).exists()]


def words(pages: list[Path]) -> int:
    """Words of pages."""
    return sum(len(page.read_text(encoding="utf-8").split()) for page in pages)


def code_lines(text: str, tree: ast.Module) -> int:
    """Lines that hold code: neither empty, nor comments, nor docstrings."""
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    docs: set[int] = set()
    for node in ast.walk(tree):
        if isinstance(node, documented) and ast.get_docstring(node, clean=False) is not None:
            docs |= set(range(node.body[0].lineno, (node.body[0].end_lineno or 0) + 1))
    lines = enumerate(text.splitlines(), 1)
    return sum(number not in docs and line.strip()[:1] not in ("", "#") for number, line in lines)


def figures() -> Iterator[tuple[str, int, int | None]]:
    """Name, value and limit (None if it is only printed) of each figure."""
    product = [path for path in files(".py") if path.relative_to(ROOT).parts[0] in ROOMS]
    texts = [path.read_text(encoding="utf-8") for path in product]
    trees = [ast.parse(text) for text in texts]
    classes = Counter(node.name for tree in trees for node in ast.walk(tree) if isinstance(node, ast.ClassDef))
    tests = [ast.parse(path.read_text(encoding="utf-8")) for path in files(".py") if "tests" in path.parts]
    froms = [node for tree in tests for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    yield "lines of the product", sum(text.count("\n") for text in texts), None
    yield "of them code", sum(map(code_lines, texts, trees)), None
    yield "modules", len(product), None
    yield "class names borne twice", sum(count > 1 for count in classes.values()), 0
    yield "deep imports of tests", sum((node.module or "").count(".") > 2 for node in froms), None
    yield "words of README.md", words([ROOT / "README.md"]), README_WORDS
    yield "words of all pages", words(files(".md")), PAGES_WORDS


if __name__ == "__main__":
    found = list(figures())
    for name, value, limit in found:
        print(f"{value:7d}  {name}{f', at most {limit}' if limit else ''}")
    sys.exit(any(limit is not None and value > limit for _, value, limit in found))
