"""Code, messages and pages use the terms of CONTRIBUTING.md: two lists of unwanted terms with replacements.

Ordinary English is free; keys of scenes, commands, JSON keys, CSV headers and recorded names stay as they are.
"""

import ast
import io
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest
from page_blocks import ROOT
from size import files

PHRASES = {  # in docstrings, comments, messages and pages
    r"\bis told\b(?! (what|how|that|it|the|something|anything|nothing|everything|all))": "is reported",
    r"\btold apart\b": "distinguished",
    r"\b(is|are|be|not) judged\b": "checked",
    r"\bis used to \d": "utilisation",
    r"\bno bar\b": "no error estimate",
    r"\brungs? of\b": "level of fidelity",
    r"; [A-Z]\w*Error\.?(?=\"\"\"|$)": "raises ... if ...",
}
WORDS = {  # in the names of modules, classes, functions, arguments and variables of the product
    "told": "message, reported", "tell": "report", "rung": "level, candidate", "foreseen": "required",
    "tape": "recorder", "desk": "queue", "vigil": "stall detector", "lookout": "liveness monitor",
    "audience": "publisher", "rent": "budget", "bench": "context", "zoo": "examples", "door": "listener",
    "stranger": "unauthenticated client", "chance": "error estimate", "untold": "unreported",
}  # fmt: skip
KEPT = {  # names that users' models, files or the command line have
    "tell": "a method of Hybrid", "chance": "a row of stored studies", "zoo": "the folder of example models",
}  # fmt: skip
PRODUCT = ("coordinator", "nodes", "kernel", "recordings")


def prose(path: Path) -> Iterator[tuple[int, str]]:
    """Lines of text with their numbers: of a page all, of code comments and strings."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".md":
        yield from enumerate(text.splitlines(), 1)
        return
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type in (tokenize.COMMENT, tokenize.STRING):
            yield from enumerate(token.string.splitlines(), token.start[0])


def phrases(lines: Iterator[tuple[int, str]]) -> Iterator[str]:
    """What to write instead, for each phrase of the list in some lines."""
    for number, line in lines:
        for phrase, better in PHRASES.items():
            if found := re.search(phrase, line):
                yield f"{number}: '{found[0]}': write '{better}'"


def names(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """All names that a module defines, with their lines."""
    for node in ast.walk(tree):
        match node:
            case ast.ClassDef(name=name) | ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name):
                yield node.lineno, name
            case ast.arg(arg=name) | ast.Name(id=name, ctx=ast.Store()) | ast.Attribute(attr=name, ctx=ast.Store()):
                yield node.lineno, name


def words(name: str) -> list[str]:
    """The words of a name, in small letters: BrakeActor and brake_actor are brake, actor."""
    return [word.lower() for word in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", name)]


def misnamed(found: Iterator[tuple[int, str]]) -> Iterator[str]:
    """What to write instead, for each name with a word of the list."""
    for number, name in found:
        for word in {*words(name)} & WORDS.keys():
            if word not in KEPT:
                yield f"{number}: '{name}': say {WORDS[word]}"


@pytest.mark.parametrize("ending", [".py", ".md"])
def test_pages_and_docstrings_contain_no_unwanted_phrase(ending: str) -> None:
    here = (path for path in files(ending) if path != Path(__file__) and path.name != "CONTRIBUTING.md")
    assert [f"{path.relative_to(ROOT)}:{x}" for path in here for x in phrases(prose(path))] == []


def test_names_in_the_code_contain_no_unwanted_word() -> None:
    product = [path for path in files(".py") if path.relative_to(ROOT).parts[0] in PRODUCT]
    found = [
        f"{path.relative_to(ROOT)}:{x}"
        for path in product
        for x in misnamed(iter([(1, path.stem), *names(ast.parse(path.read_text(encoding="utf-8")))]))
    ]
    assert found == []


def test_the_search_for_unwanted_words_finds_every_planted_one() -> None:
    tree = ast.parse("class Desk:\n    def exit_told(self, vigil):\n        self.rung = [tape for tape in vigil]\n")
    assert [x.partition(":")[0] for x in misnamed(names(tree))] == ["1", "2", "2", "3", "3"]
    assert [*phrases(iter([(7, "the error is told at its line"), (8, "it is told that")]))] == [
        "7: 'is told': write 'is reported'"
    ]


def test_the_table_of_terms_on_the_documentation_page_is_complete() -> None:
    page = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    for term in ("utilisation", "off-lead", "block support", "level of fidelity", "error estimate", "lookahead"):
        assert term in page, term
