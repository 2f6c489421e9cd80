"""Draws lines for readers: `python tests/pages/sample.py --seed 1` prints 60 docstrings, 40 messages, 40 test names.

A reader who knows lifting, DEVS and multibody dynamics, but not this code, marks each line that is not understood
at the first reading; 95 % have to be.
"""

from __future__ import annotations

import argparse
import ast
import random
from collections.abc import Iterator
from pathlib import Path

from page_blocks import ROOT
from size import files
from test_every_folder_is_packaged import ROOMS

DOCSTRINGS, MESSAGES, NAMES = 60, 40, 40
SENTENCE = 5  # words: shorter texts are labels


def docstrings(path: Path, tree: ast.Module) -> Iterator[str]:
    """Summaries of public classes and functions, with the place and name that a reader sees beside them."""
    for node in ast.walk(tree):
        if not isinstance(node, (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)) or node.name.startswith("_"):
            continue
        if text := ast.get_docstring(node):
            yield f"{path.relative_to(ROOT).as_posix()} {node.name}: {' '.join(text.split(chr(10) * 2)[0].split())}"


def text_of(node: ast.expr) -> str:
    """A string or f-string as it is read; what is filled in is written as {expression}, other expressions are empty."""
    match node:
        case ast.Constant(value=str(text)):
            return text
        case ast.FormattedValue(value=value):
            return f"{{{ast.unparse(value)}}}"
        case ast.JoinedStr(values=parts):
            return "".join(map(text_of, parts))
    return ""


def messages(path: Path, tree: ast.Module) -> Iterator[str]:
    """Texts of the errors that a module raises."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call):
            for text in map(text_of, node.exc.args):
                if len(text.split()) >= SENTENCE:
                    yield f"{path.relative_to(ROOT).as_posix()}: {text}"


def names(path: Path, tree: ast.Module) -> Iterator[str]:
    """Names of tests as sentences."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_"):
            yield node.name.removeprefix("test_").replace("_", " ")


def main() -> None:
    """Print the three samples, numbered."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    seed = parser.parse_args().seed
    sources = [(path, ast.parse(path.read_text(encoding="utf-8"))) for path in files(".py")]
    product = [(path, tree) for path, tree in sources if path.relative_to(ROOT).parts[0] in ROOMS]
    tests = [(path, tree) for path, tree in sources if path.relative_to(ROOT).parts[0] == "tests"]
    drawn = random.Random(seed)
    for title, count, found in (
        ("docstrings", DOCSTRINGS, [text for source in product for text in docstrings(*source)]),
        ("messages", MESSAGES, [text for source in product for text in messages(*source)]),
        ("test names", NAMES, [text for source in tests for text in names(*source)]),
    ):
        print(f"# {title} ({count} of {len(found)})")
        for number, text in enumerate(drawn.sample(found, count), 1):
            print(f"{title[0]}{number}. {text}")


if __name__ == "__main__":
    main()
