"""`release` breaks a sling or a rope for good; single ones are hooked and unhooked by their names."""

from __future__ import annotations

from pathlib import Path

import pytest
from heavylift.coordinator.run import run
from heavylift.kernel import SceneError
from heavylift.nodes.plan import Hookup, UnhookSling
from heavylift.nodes.scene import LoadedScene, parse
from heavylift.recordings import Recording
from lifting import hook_ropes

G, MASS, STIFFNESS = 9.80665, 10e3, 1e5  # of the load [kg], of each rope [N/m]
AT_REST = MASS * G / 3 / STIFFNESS  # how far each of three ropes is stretched [m]
THREE = f"""\
heavylift: 1
name: three
mechanism:
  bodies: {{load: {{mass: 10 t}}}}
  joints: {{slide: {{type: prismatic, child: load, axis: [0, 0, 1], start: {-10 - AT_REST!r} m}}}}
  ropes:
    a: {{start: {{body: world}}, end: {{body: load}}, EA: 1 MN, length: 10 m}}
    b: {{start: {{body: world}}, end: {{body: load}}, EA: 1 MN, length: 10 m}}
    c: {{start: {{body: world}}, end: {{body: load}}, EA: 1 MN, length: 10 m}}
actions: [{{wait: 1 s}}, {{b: release}}, {{wait: 4 s}}]
"""
TAUT = "{all hooks: hoist 0.3 m/min until lifted}"


def lift(*actions: str, mechanism: str = "") -> LoadedScene:
    """The bundled lift with another action list."""
    listed = "".join(f"  - {action}\n" for action in actions)
    return parse(f"extends: lift\nname: lift\nend: 120 s\nactions:\n{listed}{mechanism}", "scene.yaml", passing=True)


def peaks_of(path: Path) -> dict[str, float]:
    """The largest tension of each rope of a run [N]."""
    return {name: peak["tension"] for name, peak in Recording(path).fact("peaks", {}).items()}


def refused(*actions: str, mechanism: str = "") -> str:
    with pytest.raises(SceneError) as refusal:
        lift(*actions, mechanism=mechanism)
    return str(refusal.value).splitlines()[0]


def test_after_a_sling_breaks_the_other_slings_have_the_peak_tension_of_the_energy_balance(tmp_path: Path) -> None:
    """Undamped, the load swings about its new rest as far as it was above it: peak = 2 m g / 2 - m g / 3."""
    run(parse(THREE), tmp_path / "three.mcap", in_process=True)
    peaks = peaks_of(tmp_path / "three.mcap")
    assert peaks["a"] == pytest.approx(2 * MASS * G / 2 - MASS * G / 3, rel=1e-4)
    assert peaks["c"] == pytest.approx(peaks["a"], rel=1e-9)
    assert peaks["b"] == pytest.approx(MASS * G / 3, rel=1e-6)


def test_after_a_sling_breaks_the_lift_hangs_in_equilibrium_on_the_remaining_slings() -> None:
    scene = lift(
        TAUT, "all hooks: hoist 3 m/min by 1.5 m", "loader-3.sling-1: release", mechanism="block: {mass: 450 t}\n"
    )
    before, after = (next(s for s in reversed(scene.states) if s.action == n) for n in (2, 3))
    assert before.tensions["loader-3.sling-1"] > 600e3
    assert after.tensions["loader-3.sling-1"] == 0.0
    ropes = list(hook_ropes(scene.plan))
    assert sum(after.tensions[r] for r in ropes) == pytest.approx(sum(before.tensions[r] for r in ropes), rel=1e-3)
    assert after.tensions["loader-3.sling-2"] > 1.8 * before.tensions["loader-3.sling-2"]
    message = [finding.subject for finding in scene.findings if finding.state == "red"]
    assert {*message} == {"loader-3.sling-2", "R2"}  # said, and no reason to refuse the scene: it is run for that


def test_a_single_sling_can_be_unhooked_and_hooked_elsewhere() -> None:
    orders = [a.orders[0] for a in lift("loader-1.sling-1: unhook", "loader-1.sling-1: hook [P1]").plan.actions]
    assert [(type(order), order.sling) for order in orders if isinstance(order, Hookup | UnhookSling)] == [
        (UnhookSling, "loader-1.sling-1"),
        (Hookup, "loader-1.sling-1"),
    ]


def test_a_rope_of_a_mechanism_can_be_hooked_at_its_end_point(tmp_path: Path) -> None:
    text = THREE.replace("c: {start", "c: {hooked: false, start").replace("b: release", "c: hook").replace(
        "length: 10 m}\nactions", "length: 11 m}\nactions"
    )  # fmt: skip
    run(parse(text), tmp_path / "hooked.mcap", in_process=True)
    peaks = peaks_of(tmp_path / "hooked.mcap")
    assert peaks["a"] == pytest.approx(2 * MASS * G / 2 - MASS * G / 3, rel=1e-4)
    assert peaks.get("c", 0.0) == 0.0


TAG = "mechanism: {ropes: {tag: {start: {body: world}, end: {body: block}, EA: 1 MN, length: 100 m}}}\n"


@pytest.mark.parametrize(
    ("actions", "told"),
    [
        (
            ("loader-1.sling-1: release", "loader-1.sling-1: hook [P1]"),
            "loader-1.sling-1 is broken and cannot be hooked again",
        ),
        (
            ("loader-1.sling-1: unhook", "loader-1.sling-1: release"),
            "sling loader-1.sling-1 is not hooked and cannot be unhooked",
        ),
        (
            ("loader-1.sling-1: hook",),
            "name the lugs, such as 'hook [P1, P2]'",
        ),
        (
            ("tag: hook [P1]",),
            "'tag' has a fixed end in the scene: write 'hook' without lugs",
        ),
        (("crane H1: release",), "'crane H1' cannot release"),
    ],
)
def test_an_order_to_break_or_hook_an_unsuitable_rope_is_refused(actions: tuple[str, ...], told: str) -> None:
    at = f"scene.yaml:{4 + len(actions)}:"
    sentence = refused(*actions, mechanism=TAG)
    assert sentence.startswith(at)
    assert f": {told}" in sentence


def test_a_mechanism_winch_without_a_stated_speed_accepts_any_hoist_speed() -> None:
    winch = "{ramp: 1 m/s2, shortest: 9 m, longest: 200 m}"
    rope = f"{{start: {{body: world}}, end: {{body: block}}, EA: 1 MN, length: 100 m, winch: {winch}}}"
    scene = lift("tugger: hoist 30 m/min by 1 m", mechanism=f"mechanism: {{ropes: {{tugger: {rope}}}}}\n")
    assert scene.statics.known
