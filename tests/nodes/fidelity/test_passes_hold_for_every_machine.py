"""Model levels transform any machine: pure, idempotent, in equilibrium at the start, with equal masses."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import msgspec
import numpy as np
import pytest
from heavylift.coordinator.ladder import at_level
from heavylift.coordinator.record import Played, play
from heavylift.kernel import SceneError
from heavylift.kernel.analysis import modes
from heavylift.kernel.description import System
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.models import system
from heavylift.nodes.models.levels import PASSES, as_modelled, left_out
from heavylift.nodes.plan import Fidelity, Mechanism, Plan, planar
from heavylift.nodes.scene import bundled, load, parse
from heavylift.nodes.scene.text import library
from lifts_of_kinds import lift_of_kinds
from lifts_of_the_world import lift_of_the_world

SCENES = Path(__file__).parents[3] / "nodes" / "scenes"
BUNDLED = sorted(file.stem for file in SCENES.glob("*.yaml"))
RANDOM = [f"random {seed}" for seed in range(60)]
TYPE = Path(__file__).parents[2] / "data" / "bending-boom.yaml"
HANGING = ("crawler", "hall", "jib", "floating", "spreader", "edge", "lift", "in-turn")
LIFTS = list(dict.fromkeys([*HANGING, *RANDOM[:4], *BUNDLED, *RANDOM]))
DAILY = 16  # of these lifts; the others with --full
FIDELITIES = (
    Fidelity(ropes="massive", lumps=1),
    Fidelity(ropes="massive", lumps=4, girder="elastic"),
    Fidelity(rope_mass="lumped", slings="rigid", pads="standing"),
    Fidelity(ropes="rigid", slings="rigid", rope_mass="lumped", girder="elastic"),
    Fidelity(motion="across"),
    Fidelity(motion="along", ropes="massive", lumps=2),
)
ROUNDING, STATIC, STILL = (
    1e-12,
    1e-5,
    2e-3,
)  # relative: of masses, of tensions at the start, of those in its first second
CAUGHT = 5e-2  # relative, of peaks by more lumps; one that a hook overtakes makes them 40 % higher
STRETCHED = 2e-2  # relative, of lengths of a rope: by its load at the start
COUPLED = 1e-2  # relative, of a stiff mode by what hangs below
LANDING = 2e-3  # relative, of peaks that one more lump changes


@cache
def plan_of(name: str) -> Plan:
    word, _, seed = name.partition(" ")
    return (parse(lift_of_the_world(int(seed)).text, f"{word}.yaml") if seed else load(name)).plan


def boom(folder: Path, more: str = "") -> Plan:
    """A lift by a type that is one file."""
    (folder / "boom.yaml").write_text(TYPE.read_text(encoding="utf-8"), encoding="utf-8")
    scene = "heavylift: 1\nname: boom\nend: 6 s\ncranes: {crane: {type: boom.yaml}}\n"
    (folder / "scene.yaml").write_text(scene + more, encoding="utf-8")
    return load(folder / "scene.yaml").plan


def given(plan: Plan, fidelity: Fidelity) -> Iterator[tuple[Mechanism, Fidelity]]:
    """All machines of a plan, with a fidelity that locks what leaves its plane."""
    every = plan.machines
    for machine in every:
        yield machine, planar(fidelity, every)


@pytest.mark.parametrize("name", LIFTS)
@pytest.mark.large(beyond=DAILY)
def test_each_simplification_of_a_machine_for_a_model_level_is_pure_and_idempotent(name: str) -> None:
    for fidelity in FIDELITIES:
        for machine, level in given(plan_of(name), fidelity):
            before = repr(machine)
            for each in PASSES:
                once = each.apply(machine, level)
                assert repr(machine) == before
                assert repr(each.apply(machine, level)) == repr(once)
                assert each.apply(once, level) == once, each.name


@pytest.mark.parametrize("name", LIFTS)
@pytest.mark.large(beyond=DAILY)
def test_a_lumped_rope_has_stiffness_and_damping_of_the_continuous_rope_at_every_length(name: str) -> None:
    for machine, _ in given(plan_of(name), Fidelity()):
        for lumps in (1, 2, 8):
            fidelity = Fidelity(ropes="massive", lumps=lumps)
            found = as_modelled(at_level(plan_of(name), fidelity), machine).system.ropes
            for rope in (r for r in machine.system.ropes if any(x.rope == r.name and not x.why for x in machine.heavy)):
                chain = [r for r in found if r.name.partition("~")[0] == rope.name]
                assert len(chain) == lumps + 1
                assert sum(r.L0 / r.EA for r in chain) == pytest.approx(rope.L0 / rope.EA, rel=STRETCHED)
                for piece in chain:
                    assert piece.damping * piece.L0 == pytest.approx(rope.damping * rope.L0, rel=STRETCHED)


@pytest.mark.parametrize("seed", [70_012, 70_024])
@pytest.mark.large
def test_a_recoiling_hook_block_does_not_overtake_its_rope(seed: int) -> None:
    """The slings of one of several hooks are let go under load; what it weighs is thrown up by its rope."""
    plan = parse(lift_of_kinds(seed).text).plan
    few, many = (play(level(plan, Fidelity(ropes="massive", lumps=n, girder="elastic"))).peaks for n in (2, 8))
    for name, peak in few.items():
        assert "~" in name or many[name].tension == pytest.approx(peak.tension, rel=CAUGHT)


def level(plan: Plan, fidelity: Fidelity) -> Plan:
    """The plan at a level, in steps that suffice for its peaks."""
    return msgspec.structs.replace(at_level(plan, fidelity), method="radau5", tolerance=1e-4)


@pytest.mark.parametrize("name", LIFTS)
@pytest.mark.large(beyond=DAILY)
def test_lumped_ropes_have_mass_and_centre_of_mass_of_the_continuous_rope(name: str) -> None:
    for machine, _ in given(plan_of(name), Fidelity()):
        rows = {row.rope: row for row in machine.heavy if not row.why}
        lengths = {rope.name: rope.L0 for rope in machine.system.ropes}
        plain = as_modelled(at_level(plan_of(name), Fidelity()), machine).system
        for fidelity in (Fidelity(ropes="massive", lumps=n) for n in (1, 2, 4)):
            found = as_modelled(at_level(plan_of(name), fidelity), machine).system
            whole = sum(row.line * (lengths[rope] - row.lead) for rope, row in rows.items())
            assert _mass(found) - _mass(plain) == pytest.approx(whole, rel=1e-9)
            placed = {joint.child: joint.p_PJ for joint in found.joints}
            for rope, row in rows.items():
                lumps = {body.name: body.mass for body in found.bodies if body.name.startswith(f"{rope}.lump-")}
                lumps = {name: mass for name, mass in lumps.items() if mass}
                middle = sum(m * placed[f"{x}-x"][2] for x, m in lumps.items()) / sum(lumps.values())
                top, eye = row.ends[0][2], row.ends[1][2]
                assert middle == pytest.approx((top + eye) / 2.0, abs=ROUNDING * top)


def _mass(system: System) -> float:
    return sum(body.mass for body in system.bodies) + sum(rope.mass for rope in system.straight_ropes)


@cache
def still(name: str, fidelity: Fidelity) -> Played:
    return play(quiet(at_level(plan_of(name), fidelity)))


def quiet(plan: Plan) -> Plan:
    """The same with nothing to do for a second."""
    return msgspec.structs.replace(plan, actions=(), lists=(), models=(), limits=(), interlocks=(), end=1.0)


def tensions(run: Played, what: str = "rope/tension") -> dict[str, np.ndarray]:
    block = run.layout.find(what)
    return {name: run.rows[:, block.start + i] for i, name in enumerate(block.names)}


@pytest.mark.parametrize("name", [*HANGING, *RANDOM[:6]])
@pytest.mark.large(beyond=4)
def test_hook_ropes_start_at_rest_under_their_load_and_weight(name: str) -> None:
    plan = plan_of(name)
    if plan.lists:
        plan = msgspec.structs.replace(plan, lists=())
    plain = tensions(play(quiet(plan)))
    for fidelity in (Fidelity(rope_mass="lumped"), Fidelity(ropes="massive", lumps=2, girder="elastic")):
        rich = tensions(play(quiet(at_level(plan, fidelity))))
        for row in (row for machine in plan.machines for row in machine.heavy if not row.why):
            assert rich[row.rope][0] == pytest.approx(plain[row.rope][0], rel=STATIC)
            if fidelity.ropes == "massive":
                rope = next(r for m in plan.machines for r in m.system.ropes if r.name == row.rope)
                weight = row.line * (rope.L0 - row.lead) * plan.gravity
                assert rich[f"{row.rope}~1"][0] == pytest.approx(plain[row.rope][0] + weight, rel=STATIC)
            if not any(machine.name == "wind" for machine in plan.machines):
                swings = (
                    np.abs(rich[row.rope] - rich[row.rope][0]).max()
                    - np.abs(plain[row.rope] - plain[row.rope][0]).max()
                )
                assert swings < STILL * plain[row.rope][0]


@pytest.mark.parametrize("name", ["hall", "crawler", "spreader"])
@pytest.mark.large(beyond=2)
def test_a_rope_model_with_more_lumps_is_closer_to_the_continuous_rope(name: str) -> None:
    """Peaks of hook ropes; ropes that weigh a hundredth of their load leave as little."""
    runs = []
    for n in (1, 2, 4):
        level = Fidelity(ropes="massive", lumps=n)
        run = play(msgspec.structs.replace(at_level(plan_of(name), level), limits=(), method="radau5", tolerance=1e-5))
        hooks = {hook.rope for machine in plan_of(name).machines for hook in machine.hooks}
        runs.append({rope: peak.max() for rope, peak in tensions(run, "rope/peak").items() if rope in hooks})
    one, two, four = runs
    for rope, peak in four.items():
        assert abs(two[rope] - peak) <= abs(one[rope] - peak) + LANDING / 10.0 * peak
        assert two[rope] == pytest.approx(peak, rel=LANDING)


def test_a_new_crane_type_with_an_elastic_boom_needs_one_type_file_only(tmp_path: Path) -> None:
    """It starts bent and at rest, its hook where it is on a rigid boom."""
    plan = boom(tmp_path)
    assert "elastic parts rigid" in left_out(plan)
    rigid, bent = (as_modelled(at_level(plan, Fidelity(girder=g)), plan.machines[0]) for g in ("rigid", "elastic"))
    one, two = ({body.name: body for body in x.system.bodies} for x in (rigid, bent))
    flexible = two["crane.boom"].flexible
    assert one["crane.boom"].flexible is None
    assert flexible is not None
    assert flexible.beam is not None
    assert two["crane.boom"].mass + flexible.beam.mass_per_length * flexible.beam.length == one["crane.boom"].mass
    w, F, EI, L = 20e3 / 40.0 * 9.80665 * 0.45, 2e3 * 9.80665 * 0.45, 8e9, 40.0  # 63 degrees up: cos is 0.45
    sag = w * L * L * L * L / (8.0 * EI) + F * L * L * L / (3.0 * EI)
    assert -sum(flexible.start) == pytest.approx(sag, rel=0.05)
    pulls = tensions(play(quiet(at_level(plan, Fidelity(girder="elastic")))))["crane.main"]
    assert pulls[0] == pytest.approx(2e3 * plan.gravity, rel=STATIC * 10.0)
    assert np.abs(pulls - pulls[0]).max() < STILL * pulls[0]


def test_a_rope_over_sheaves_is_modelled_without_mass_and_the_reason_is_reported() -> None:
    scene = """\
heavylift: 1
name: ropes
end: 1 s
mechanism:
  bodies: {a: {mass: 1 t}, b: {mass: 1 t}}
  joints:
    one: {type: prismatic, child: a, axis: [0, 0, 1]}
    two: {type: prismatic, child: b, axis: [0, 0, 1], at: [5 m, 0 m, 0 m]}
  ropes:
    over:
      start: {body: world, at: [-1 m, 0 m, 9 m]}
      over: [{body: a, at: [0 m, 0 m, 0 m], radius: 1 m}]
      end: {body: world, at: [1 m, 0 m, 9 m]}
      EA: 10 MN
      length: 21.57 m
    plumb:
      start: {body: world, at: [5 m, 0 m, 9 m]}
      end: {body: b, at: [0 m, 0 m, 0 m]}
      EA: 10 MN
      length: 8.99 m
"""
    plan = parse(f"{scene}  elastic: {{over: {{mass per length: 5 kg/m}}, plumb: {{mass per length: 5 kg/m}}}}\n").plan
    before = scene.replace("      EA: 10 MN\n", "      EA: 10 MN\n      mass per length: 5 kg/m\n")
    assert parse(before).plan.machines == plan.machines
    why = {row.rope: row.why for machine in plan.machines for row in machine.heavy if row.why}
    assert why == {"over": "it runs over sheaves or edges"}
    found = play(at_level(plan, Fidelity(ropes="massive", lumps=2)))
    assert "plumb~1" in tensions(found)
    assert "over~1" not in tensions(found)


def swings(plan: Plan) -> list[float]:
    """Frequencies of small motions about the start [Hz]."""
    s = Simulation(system(plan))
    s.start()
    return [mode.frequency for mode in modes(s).oscillations]


def test_a_prescribed_drive_with_a_stiffness_is_compliant_where_elastic_parts_are_modelled() -> None:
    """The bridge of a hall, 125 t with its trolley, on 500 MN/m: far above the swing of what hangs there."""
    plan = load("hall", ["machines.hall.elastic={hall.travelling: {stiffness: 500 MN/m}}"]).plan
    before = load("hall", ["machines.hall.drives.hall.travelling.stiffness=500 MN/m"]).plan
    assert [(m.system, m.servos) for m in before.machines] == [(m.system, m.servos) for m in plan.machines]
    soft = at_level(plan, Fidelity(girder="elastic"))
    assert "drives stiff" in left_out(plan)
    assert "drives stiff" not in left_out(soft)
    found, stiff = (swings(level) for level in (soft, plan))
    assert min(abs(f / (math.sqrt(500e6 / 125e3) / (2.0 * math.pi)) - 1.0) for f in found) < COUPLED
    assert len(found) == len(stiff) + 1
    assert play(soft).t[-1] == pytest.approx(play(plan).t[-1], rel=COUPLED)


def test_a_compliant_servo_is_refused_for_a_drive_that_carries_weight() -> None:
    with pytest.raises(SceneError, match=r"drives\.jib\.luffer\.stiffness: weight acts on this drive"):
        load("jib", ["machines.jib.drives.jib.luffer.stiffness=500 MN m/rad"])


@pytest.mark.parametrize(
    ("elastic", "message"),
    [
        ("jib.slew: {stiffness: 5 MN m/rad}", "there is no prescribed drive 'jib.slew', body or rope"),
        ("jib.slewer: {stiffness: 5 MN/m}", "'5 MN/m' is not a valid torsional stiffness"),
        ("jib.rope: {mass per length: 5 kg/m}", "there is no rope 'jib.rope'"),
        ("jib.booms: {EI: 5 GN m2}", "there is no rigid body 'jib.booms'"),
        ("jib.upper: {span: 5 m, mass: 1 t, stiffness: 1 MN/m, height: 1 m, slides: [x]}", "there is no joint 'x'"),
    ],
)
def test_an_optional_part_that_a_crane_type_cannot_have_is_reported(elastic: str, message: str) -> None:
    with pytest.raises(SceneError, match=re.escape(message)):
        load("jib", [f"machines.jib.elastic={{{elastic}}}"])


def test_a_scene_with_the_former_keys_of_a_girder_section_is_still_read(tmp_path: Path) -> None:
    """A type that writes `girders:` has the same parts as one that writes `elastic:`."""
    text, scene = library()["goliath-900"].read_text(encoding="utf-8"), bundled()["lift"].read_text(encoding="utf-8")
    found = []
    for section in ("elastic:", "girders:"):
        (tmp_path / "own.yaml").write_text(text.replace("\nelastic:", f"\n{section}"), encoding="utf-8")
        given = scene.replace("type: goliath-900", "type: own.yaml")
        found.append(parse(given, str(tmp_path / "lift.yaml")).plan.machines)
    assert found[0] == found[1]
    assert any(machine.girders for machine in found[0])


@pytest.mark.parametrize("name", ["crawler", "jib", "floating"])
@pytest.mark.large(beyond=2)
def test_level_luffing_keeps_the_hook_height_for_massless_and_lumped_ropes(name: str) -> None:
    """All pieces follow the boom as their rope does."""
    order = "{crane}: luff 0.3 deg/s by 2 deg\n    {crane} main: hold height\n"
    crane = next(x.name for x in load(name).plan.machines if x.hooks)
    actions = f"actions:\n  - stage: luff\n    {order.format(crane=crane)}"
    plan = parse(f"heavylift: 1\nname: luffs\nextends: {name}\nend: 9 s\n{actions}", "luffs.yaml").plan
    ends = []
    for lumps in (0, 1, 3):
        fidelity = Fidelity(ropes="massive", lumps=lumps) if lumps else Fidelity()
        run = play(at_level(plan, fidelity))
        hook = next(hook for machine in plan.machines for hook in machine.hooks)
        ends.append(run.past.part(len(run.t) - 1, len(run.t)).poses[hook.eye.body][0, 2])
    assert ends == pytest.approx([ends[0]] * 3, abs=0.02)
