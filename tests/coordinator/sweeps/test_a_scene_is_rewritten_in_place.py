"""Values of a scene replaced where they stand: comments, blanks and the style of everything else stay."""

from __future__ import annotations

import pytest
from heavylift.coordinator.sweeps import rewritten
from heavylift.kernel import SceneError
from heavylift.nodes.scene import load
from heavylift.nodes.scene.text import Path

TEXT = """\
# a lift
name: x
block: {mass: 300 t}            # with what is on it
actions:
  - stage: up                   # first
    hooks: hoist 1 m/min by 1 m # slowly
  - {stage: out, cranes: "travel 1 m/min by 1 m"}
  - hooks: 'lower 1 m/min by 1 m'
  - wait: 5 s
"""
CHANGES: dict[Path, str] = {
    ("block", "mass"): "310 t",
    ("actions", 0, "hooks"): "hoist 12 m/min by 1 m",
    ("actions", 1, "cranes"): "travel 2 m/min by 1 m",
    ("actions", 1, "when"): "after 3 s",
    ("actions", 2, "hooks"): "lower 2 m/min by 1 m",
    ("actions", 2, "when"): "after 4 s",
}


def test_rewriting_values_and_adding_keys_keeps_comments_and_their_columns() -> None:
    assert (
        rewritten(TEXT, "x.yaml", CHANGES)
        == """\
# a lift
name: x
block: {mass: 310 t}            # with what is on it
actions:
  - stage: up                   # first
    hooks: hoist 12 m/min by 1 m # slowly
  - {when: after 3 s, stage: out, cranes: "travel 2 m/min by 1 m"}
  - when: after 4 s
    hooks: 'lower 2 m/min by 1 m'
  - wait: 5 s
"""
    )


def test_a_key_added_to_an_action_by_the_workbench_is_written_after_the_name_of_its_stage() -> None:
    lines = rewritten(load("turnover").text, "turnover.yaml", {("actions", 3, "when"): "after 210 s"}).splitlines()
    at = lines.index("    when: after 210 s")
    assert lines[at - 1 : at + 2 : 2] == ["  - stage: travel", "    cranes: travel 30 m/min ramp 0.03234 m/s2 by 120 m"]


@pytest.mark.parametrize(
    ("text", "path"),
    [
        ("actions:\n  - hooks: >\n      hoist 1 m/min\n      by 1 m\n", ("actions", 0, "hooks")),  # of two lines
        ("a: &x 1 m\nb: *x\n", ("b",)),  # an alias
        ("actions: []\n", ("actions", 0, "when")),  # of nothing
    ],
)
def test_rewriting_a_value_that_cannot_be_changed_without_losing_comments_is_refused(text: str, path: Path) -> None:
    with pytest.raises(SceneError, match="cannot be changed without losing its comments"):
        rewritten(text, "x.yaml", {path: "2 m"})
