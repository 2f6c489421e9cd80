"""Slings, spreaders and equalisers between hooks and lugs: loads, ratings, and rigging that cannot hang."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest
from heavylift.coordinator.run import run
from heavylift.kernel import SceneError
from heavylift.nodes.scene import LoadedScene, bundled, load, parse
from heavylift.recordings import Recording, report

G = 9.80665
TEXT = bundled()["spreader"].read_text(encoding="utf-8")


@cache
def spreader() -> LoadedScene:
    """The bundled scene with a sheave without friction."""
    return load("spreader", ["rigging.rear.friction=0"])


def test_a_tree_of_rigging_hangs_in_equilibrium_from_the_start() -> None:
    """The links carry the spreader alone, the hook ropes their blocks besides; nothing else is taut."""
    first = spreader().statics.states[0]
    carried = {name: tension for name, tension in first.tensions.items() if tension > 0.0}
    links = dict.fromkeys(("links.sling-1", "links.sling-2"), 9e3 * G)
    hooks = {"crane.H1": 21e3 * G, "crane.H2": 21e3 * G, "crane.H3": 12e3 * G}
    assert carried == pytest.approx(hooks | links, rel=1e-6)
    placed = {joint.child: joint.q0[:3] for m in spreader().plan.machines for joint in m.system.joints}
    for body in ("beam", "crane.H1", "crane.H3"):
        assert placed[body] == pytest.approx(first.poses[body][0], abs=1e-12)
    assert {m.name: m.taut for m in spreader().plan.machines}["links"] == tuple(sorted(links))


def test_an_equalised_sling_pair_makes_three_hooks_determinate() -> None:
    """F1 + F2 + 2 R = W, (F1 + F2 - 2 R) 8 m = W 0.4 m and (F2 - F1) 10 m = W 0.6 m, the legs of the pair being equal.

    The centre of mass is 3.2 m below the lugs, so the tilt of 0.2 degrees by stretched ropes moves it by a centimetre.
    """
    last = spreader().statics.states[-1]
    W = 210e3 * G
    pair = W / 2 * (1 + 0.4 / 8)
    assert last.tensions["front.sling-1"] == pytest.approx(pair / 2 - 0.03 * W, rel=5e-3)
    assert last.tensions["front.sling-2"] == pytest.approx(pair / 2 + 0.03 * W, rel=5e-3)
    leg = (26.0 - 0.4 * 3.14) / 2  # from the side of the sheave, 3.6 m beside the lug
    slant = (1 - (3.6 / leg) ** 2) ** 0.5
    assert last.tensions["rear.sling-1"] == pytest.approx((W - pair) / 2 / slant, rel=5e-3)
    hooks = sum(last.tensions[f"crane.H{i}"] for i in (1, 2, 3))
    assert hooks == pytest.approx(W + (3 * 12e3 + 18e3) * G, rel=1e-5)


def test_an_equalised_sling_pair_is_recorded_among_the_ropes(tmp_path: Path) -> None:
    """Its peak is that of its more loaded leg, its use that of the sling; the summary and the report tell both."""
    result = run(spreader(), tmp_path / "run.mcap", in_process=True)
    legs = Recording(result.recording).signal("reeving/tension").values
    assert result.peaks["rear.sling-1"][0] == pytest.approx(legs.max(), rel=1e-9)
    rated = Recording(result.recording).fact("rated", {})
    assert {name for name in result.peaks if name not in rated} == set()
    assert rated["rear.sling-1"] == pytest.approx(4e6 / (1.3 * 1.3 * 1.5 * 1.2)), "in sockets, 0027/ND 7.3.1"
    report(result.recording, tmp_path / "run.html")
    more = 1.03 * 1.05  # contingencies of weight and centre of mass
    use = f">{100 * more * legs.max() / rated['rear.sling-1']:.1f}<"
    rows = (tmp_path / "run.html").read_text().split("rear.sling-1")[1:]
    assert any(use in row[:500] for row in rows)


def test_a_bridle_of_four_legs_hangs_by_its_master_link() -> None:
    """Four legs of 8 m to lugs 2.92 m aside carry 20 t and a quarter each, the link and the hook rope all of it."""
    plain = "legs: {on: jib main, to: [N1, N2, N3, N4], length: 8 m,"
    points = "points: {top: [0 m, 0 m, 0.5 m], eye: [0 m, 0 m, -0.5 m]}"
    link = f"link: {{type: link, mass: 400 kg, size: [0.4 m, 0.4 m, 1 m], {points}}}"
    head = "head: {on: jib main, to: [link.top], length: 0.5 m, sling: {EA: 200 MN, breaking: 2 MN}}"
    text = bundled()["jib"].read_text(encoding="utf-8")
    assert plain in text
    tree = f"{link}\n  {head}\n  legs: {{on: link.eye, to: [N1, N2, N3, N4], length: 8 m,"
    up = parse(text.replace(plain, tree).split("  - stage: slew")[0], passing=True).statics.states[-1]
    slant = (1.0 - (2.5**2 + 1.5**2) / 8.0**2) ** 0.5
    for i in range(1, 5):
        assert up.tensions[f"legs.sling-{i}"] == pytest.approx(5e3 * G / slant, rel=2e-3)
    assert up.tensions["head.sling-1"] == pytest.approx(20.4e3 * G, rel=1e-6)
    assert up.tensions["jib.main"] == pytest.approx(22.4e3 * G, rel=1e-4)


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        (
            "shackle: 85 t,\n",
            "shackle: 60 t,\n",
            "shackle load of front.sling-2 would be 61.4 t, 102 %; 60.0 t is allowed",
        ),
        ("lug capacity: 100 t", "lug capacity: 61 t", "lug load of F2 would be 61.4 t, 101 %; 61.0 t is allowed"),
        (
            "    capacity: 300 t",
            "    capacity: 105 t",
            "frame load of beam would be 110.3 t, 105 %; 105.0 t is allowed",
        ),
        (
            "lug capacity: 150 t",
            "lug capacity: 70 t",
            "lug load of beam.east would be 74.5 t, 106 %; 70.0 t is allowed",
        ),
        ("breaking: 4 MN, diameter: 76 mm, termination: resin}}", "breaking: 2.9 MN}}", "104 %; 580 kN is allowed"),
    ],
)
def test_a_load_beyond_the_rating_of_its_rigging_is_refused(old: str, new: str, sentence: str) -> None:
    with pytest.raises(SceneError) as message:
        parse(changed(old, new), passing=True)
    assert sentence in str(message.value)
    assert "scene.yaml:" in str(message.value)


BAD = {
    "no such hook": ("on: crane H3", "on: crane H4", "rigging.rear.on: there is no hook or frame 'crane H4'"),
    "no such lug": ("to: [F1, F2]", "to: [F1, F3]", "rigging.front.to[1]: the block has no lug 'F3'"),
    "no such point": ("on: [beam.a, beam.b]", "on: [beam.a, beam.c]", "there is no hook or frame 'beam.c'"),
    "a lug twice": ("to: [R1, R2]", "to: [R1, F2]", "rigging.rear.to[1]: the lug F2 already carries a sling of front"),
    "too few ends": (
        "on: [beam.a, beam.b]",
        "on: [beam.a]",
        "rigging.front.on: 2 slings need 2 of them, or one for all",
    ),
    "too many lengths": ("length: 9 m", "length: [9 m, 9 m, 9 m]", "rigging.front.length: 2 slings need 2 of them"),
    "three legs": ("to: [R1, R2]", "to: [R1, R2, F1]", "rigging.rear.to: 2 values are enough here, not 3"),
    "too short a rope": ("length: 26 m", "length: 8 m", "8 m of rope with 0.6 m of slack do not reach over the sheave"),
    "too far": (
        "F2: [10 m, 8 m",
        "F2: [30 m, 8 m",
        "the lug F2 is 10 m beside its end on beam, too far for a sling of 9 m",
    ),
    "no mass": ("    mass: 18 t\n", "", "rigging.beam.mass: the key 'mass' is missing"),
    "no such type": ("type: spreader", "type: spreder", "rigging.beam.type: 'spreder' is not known here"),
    "a key of another type": ("    friction: 0.05\n", "    points: {}\n", "rigging.rear.points: unknown key 'points'"),
    "a taken name": ("  front: {on", "  crane: {on", "the name 'crane' is given twice: another machine has it, too"),
    "a reserved name": ("  front: {on", "  hooks: {on", "the name 'hooks' is reserved: choose another"),
    "nothing below": (
        "on: [beam.a, beam.b]",
        "on: crane H1",
        "rigging.beam: this frame holds nothing: add slings that are 'on' it",
    ),
    "nothing above": (
        "to: [beam.west, beam.east], length: 3 m",
        "to: [F1, F2], length: 30 m",
        "rigging.beam: nothing holds this frame",
    ),
    "below itself": (
        "to: [F1, F2], length: 9 m",
        "to: [beam.a, F2], length: 9 m",
        "rigging.beam: 'beam' hangs below itself",
    ),
    "no block": ("lugs: {F1", "lags: {F1", "unknown key 'lags'"),
}


@pytest.mark.parametrize("name", BAD)
def test_rigging_that_cannot_hang_is_reported_with_place_and_reason(name: str) -> None:
    old, new, sentence = BAD[name]
    with pytest.raises(SceneError) as message:
        parse(changed(old, new), passing=True)
    assert sentence in str(message.value)
    assert str(message.value).startswith("scene.yaml:")


def changed(old: str, new: str) -> str:
    assert old in TEXT
    return TEXT.replace(old, new)
