"""Each invalid scene is refused with its exact sentence and a caret at the place to change.

Each case edits a bundled scene in one place; `points_at` is the text at the line and column of the message.
"""

import re
from pathlib import Path

import pytest
from bad_orders import ORDERS
from bad_references import REFERENCES
from bad_words import WORDS
from bad_yards import YARDS
from heavylift.coordinator.transport import OBSERVER, check_names
from heavylift.kernel import ProtocolError, SceneError
from heavylift.nodes.models import COMMANDER, KERNEL
from heavylift.nodes.scene import bundled, load, parse
from heavylift.nodes.scene.keys import RESERVED
from lifting import unstated

TEXTS = {name: path.read_text(encoding="utf-8") for name, path in bundled().items()}
TEXTS |= {name: unstated(TEXTS[name]) for name in ("lift", "turnover")}
HEAD = re.compile(r"(?P<file>[^:]+):(?P<line>\d+):(?P<column>\d+): error: (?P<told>.*)")

BAD = WORDS | YARDS | ORDERS | REFERENCES


def refused(text: str, *settings: str) -> str:
    with pytest.raises(SceneError) as refusal:
        parse(text, "scene.yaml", settings)
    return str(refusal.value)


@pytest.mark.parametrize("name", BAD)
def test_an_invalid_scene_is_reported(name: str) -> None:
    scene, edits, points_at, sentence = BAD[name]
    text = TEXTS[scene]
    for old, new in edits:
        assert old in text
        text = text.replace(old, new, 1)
    message = refused(text)
    heads = [match for match in map(HEAD.fullmatch, message.splitlines()) if match]
    assert [match["told"] for match in heads] == [sentence]
    line, column = int(heads[0]["line"]), int(heads[0]["column"])
    assert text.splitlines()[line - 1][column - 1 :].startswith(points_at)
    shown, caret = message.splitlines()[1:3]
    assert shown[caret.index("^") :].startswith(points_at)


def test_all_errors_of_a_scene_are_reported_together_with_line_and_caret_and_hint() -> None:
    text = """\
heavylift: 1
name: two cranes
gravty: 9.81 m/s2
cranes:
  west: {type: goliath-90, at: 40}
  west: {type: goliath-900, at: 3 m}
actions:
  - all hooks: hoist 3 m/min bye 2 m
    when: angle = 90 deg
"""
    assert (
        refused(text)
        == """\
scene.yaml:2:7: error: name: a name has letters, digits, '-' and '_' only, but 'two cranes' has ' '
    2 | name: two cranes
      |       ^
scene.yaml:3:1: error: gravty: unknown key 'gravty'
    3 | gravty: 9.81 m/s2
      | ^ did you mean 'gravity'?
scene.yaml:5:16: error: cranes.west.type: 'goliath-90' is not known here
    5 |   west: {type: goliath-90, at: 40}
      |                ^ did you mean 'goliath-900'?
scene.yaml:6:3: error: cranes.west: the name 'west' is given twice (first in line 5)
    6 |   west: {type: goliath-900, at: 3 m}
      |   ^
scene.yaml:8:30: error: actions[0].all hooks: after the speed 'by' or 'to' or 'until' must follow, not 'bye'
    8 |   - all hooks: hoist 3 m/min bye 2 m
      |                              ^ did you mean 'by'?
scene.yaml:9:17: error: actions[0].when: two real numbers are never exactly equal
    9 |     when: angle = 90 deg
      |                 ^ write 'angle >= 90 deg' or 'angle <= 90 deg'
6 errors in scene.yaml"""
    )


def test_a_fault_in_a_setting_is_reported_in_the_form_of_a_fault_in_the_scene() -> None:
    assert (
        refused(TEXTS["lift"], "cranes.crane.at=41")
        == """\
--set:1:17: error: cranes.crane.at: '41' does not fit this parameter
    1 | cranes.crane.at=41
      |                 ^ the type has 0 m here: write a value of that kind
1 error in scene.yaml"""
    )
    assert "did you mean 'at'?" in refused(TEXTS["lift"], "cranes.crane.att=41 m")
    assert "the scene has no place 'actions.9'" in refused(TEXTS["lift"], "actions.9=wait 3 s")
    assert "write a setting as key=value" in refused(TEXTS["lift"], "seed")
    assert refused(TEXTS["lift"], "blocks.com[0]=3 m").splitlines()[0] == (
        "--set:1:1: error: scene: one number of 'blocks.com' cannot be set, the scene has none: set it whole, "
        "'blocks.com=[...]'"
    )
    parse(TEXTS["lift"], "scene.yaml", ["block.lugs.P1[0]=-7.9 m"])


def test_a_recording_given_as_a_scene_is_reported_as_such(tmp_path: Path) -> None:
    for size in (100, 20_000_000):  # the latter is larger than any scene
        (tmp_path / "lift.mcap").write_bytes(b"\x89MCAP0\r\n" + bytes(size))
        with pytest.raises(SceneError, match="it is a recording, not a scene; `heavylift info"):
            load(tmp_path / "lift.mcap")


@pytest.mark.parametrize("text", ["", "- a", "just words", "heavylift: [1", "a: &x [*x]", "? [a]\n: 1", "{}"])
def test_a_random_text_given_as_a_scene_is_refused_with_complete_sentences(text: str) -> None:
    assert HEAD.fullmatch(refused(text).splitlines()[0])


def test_names_that_a_run_reserves_for_itself_are_refused_as_names_of_nodes() -> None:
    assert {COMMANDER, KERNEL, OBSERVER, "event", "coordinator"} <= set(RESERVED)
    for word in ("event", OBSERVER):
        with pytest.raises(ProtocolError):
            check_names([word], "node")


def test_rope_lines_on_unknown_bodies_are_reported_together_with_all_other_faults() -> None:
    message = refused("""\
heavylift: 1
name: hanging
end: 1 s
mechanism:
  bodies:
    load: {mass: 1 t}
  joints:
    slide: {type: prismatic, child: load, axis: [0, 0, 1]}
  ropes:
    hoist:
      lines: [{start: {body: wold}, end: {body: load}}, {start: {body: world}, end: {body: lod}}]
      EA: 1 MN
      length: 9 m
""")
    assert [line for line in message.splitlines() if HEAD.fullmatch(line)] == [
        "scene.yaml:11:30: error: mechanism.ropes.hoist.lines[0].start.body: there is no body 'wold'",
        "scene.yaml:11:92: error: mechanism.ropes.hoist.lines[1].end.body: there is no body 'lod'",
    ]
