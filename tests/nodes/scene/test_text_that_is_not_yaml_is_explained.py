"""YAML mistakes are reported in plain words at their line, in every bundled scene."""

from __future__ import annotations

import random
import re
from collections.abc import Callable

import pytest
from heavylift.nodes.scene.text import content, read
from heavylift.nodes.scenes import bundled

JARGON = re.compile(r"block (end|mapping|sequence)|token|scalar|flow|stream|not YAML|stag |node")
KEY = re.compile(r"( *)[a-z][\w ]*: \w")
SCENES = {name: content(path).decode() for name, path in sorted(bundled().items())}
SECOND = "a second ':' in one line: put the inner key on a line of its own, or quotes around the text"
ALIAS = "undefined alias 'foo': no '&name' stands above; a text that begins with '*' needs quotes"
ITEM = "an item of a list stands among keys: indent it below the key whose list it is in"
LATER = "the quote that opens here closes only at the next one, in line"
COLON = "a colon is missing behind this key: write 'key: value'"


def without_colon(lines: list[str], draw: random.Random) -> tuple[int, str] | None:
    """A key whose colon is missing."""
    return changed(lines, draw, r"^( *)([a-z][\w ]*): (?=[\w])", r"\1\2 ", plain=True)


def without_blank(lines: list[str], draw: random.Random) -> tuple[int, str] | None:
    """No blank behind a colon."""
    return changed(lines, draw, r"^( *[a-z][\w ]*): (?=[\w])", r"\1:", plain=True)


def open_quote(lines: list[str], draw: random.Random) -> tuple[int, str] | None:
    """A quote that is not closed."""
    return changed(lines, draw, r"^( *[a-z][\w ]*: )(?=\w)", r'\1"', plain=True)


def open_list(lines: list[str], draw: random.Random) -> tuple[int, str] | None:
    """A list that is not closed."""
    return changed(lines, draw, r"^( *[a-z][\w ]*: \[[^\]\[{}#]*)\]( *)$", r"\1\2")


def indented_by_tab(lines: list[str], draw: random.Random) -> tuple[int, str] | None:
    """A tab in place of blanks."""
    return changed(lines, draw, r"^ +(?=[a-z])", "\t", plain=True)


def one_deeper(lines: list[str], draw: random.Random) -> tuple[int, str] | None:
    """A line that is indented by one more than its neighbours."""
    return changed(lines, draw, r"^( +)(?=[a-z][\w ]*:)", r"\1 ", plain=True)


def changed(
    lines: list[str], draw: random.Random, pattern: str, by: str, plain: bool = False
) -> tuple[int, str] | None:
    """The number of a line that is changed, and the text; `plain`: one amid keys of its own indentation."""

    def fits(i: int) -> bool:
        if not re.search(pattern, lines[i]):
            return False
        around = [KEY.match(line) for line in lines[i - 1 : i + 2]]
        indents = {found[1] if found else "#" for found in around}
        return not plain or (len(around) == 3 and len(indents) == 1 and indents != {"#"})

    possible = [i for i in range(1, len(lines)) if fits(i)]
    if not possible:
        return None
    i = draw.choice(possible)
    return i + 1, "\n".join([*lines[:i], re.sub(pattern, by, lines[i]), *lines[i + 1 :]]) + "\n"


MISTAKES: list[Callable[[list[str], random.Random], tuple[int, str] | None]] = [
    *(without_colon, without_blank, open_quote, open_list, indented_by_tab, one_deeper)
]


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda mistake: mistake.__name__)
def test_a_yaml_mistake_in_any_bundled_scene_is_reported_at_its_line_in_the_scene(
    mistake: Callable[..., tuple[int, str] | None],
) -> None:
    draw, tried = random.Random(mistake.__name__), 0
    for name, text in SCENES.items():
        for _ in range(8):
            found = mistake(text.splitlines(), draw)
            if found is None:
                continue
            tried += 1
            (fault, *_) = read(found[1], name).faults
            assert not JARGON.search(fault.sentence), (name, found[0], fault.sentence)
            assert fault.mark is not None
            assert fault.mark.line == found[0], (name, found[0], fault)
    assert tried > 25


@pytest.mark.parametrize(
    ("text", "place", "sentence"),
    [
        ("a: b: c\n", (1, 5), SECOND),
        ("heavylift 1\nb: 2\n", (1, 1), COLON),
        ("b: {m: 1\n", (1, 4), "the mapping that opens here is not closed by '}', or a comma is missing in it"),
        ("a: %x\n", (1, 4), "a text that begins with '%' needs quotes around it"),
        ("a: *foo\n", (1, 4), ALIAS),
        ("a:\n  b: 1\n  - c\n", (3, 3), ITEM),
        ("a: - 1\n", (1, 4), "a list with '-' begins on a line of its own; in one line write [first, second]"),
        ("a: [1, 2]]\n", (1, 10), "nothing is open that this ']' closes"),
        ("a: 'x' y\n", (1, 8), "text follows after the closing quote: put the quotes around all of it"),
        ("a: 1\n---\nb: 2\n", (2, 1), "'---' begins a second document; a scene is one"),
        ('n: "my\na: 1\nb: {c: "2026"}\n', (1, 4), f"{LATER} 3: one of them is missing"),
        ('b: {k: "s, EA: 1, c: "2026"}\n', (1, 8), f"{LATER} 1: one of them is missing"),
        ("a: b\nn: x\x80y\n", (2, 5), "delete the control character U+0080 here"),
    ],
)  # fmt: skip
def test_a_yaml_mistake_is_reported_in_plain_words_with_its_remedy(
    text: str, place: tuple[int, int], sentence: str
) -> None:
    (fault, *_) = read(text, "x.yaml").faults
    assert fault.mark is not None
    assert (fault.sentence, (fault.mark.line, fault.mark.column)) == (sentence, place)
