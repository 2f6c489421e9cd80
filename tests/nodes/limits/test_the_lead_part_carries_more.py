"""Sheave losses make the lead part of a hoist rope the most loaded one; its tension includes the rope's weight."""

import json
import random
from pathlib import Path

import pytest
from heavylift.coordinator.run import run
from heavylift.coordinator.verdict import verdict_of
from heavylift.kernel import SceneError
from heavylift.nodes.limits import drum_end_factor, lead_factor
from heavylift.nodes.scene import check, load
from heavylift.recordings import Recording
from lifting import bare, cranes

FORMS = {x["id"]: x for x in json.loads((Path(__file__).parents[2] / "data" / "closed_forms.json").read_text())}
EXACT = 1e-12  # relative: the same geometric series, summed in another order
TABLE = 5e-4  # the published table has three digits
HEAVY = ["block.mass=800 t", "rig.sling.breaking=20 MN"]
G = 9.80665


def crane(**keys: str) -> list[str]:
    """Settings of the crane of `lift`."""
    return [f"cranes.crane.{key.replace('_', ' ')}={value}" for key, value in keys.items()]


def parts(n: int, efficiency: float) -> list[float]:
    """Tensions of n parts behind a drum end over their mean, sheave by sheave, from the drum on."""
    found = [1.0]
    while len(found) < n:
        found.append(found[-1] * efficiency)
    return [n * tension / sum(found) for tension in found]


def test_the_lead_part_tension_of_twenty_falls_agrees_with_the_closed_form() -> None:
    given, expected = FORMS["C14"]["given"], FORMS["C14"]["expected"]
    lead = lead_factor(given["n"], 1, given["eta"])
    assert lead * given["W"] / given["n"] == pytest.approx(expected["T_lead"], rel=1e-6)
    assert given["MBF"] * given["n"] / given["W"] / lead == pytest.approx(expected["SF_lead"], rel=1e-6)
    assert f"{lead:.3f}" == "1.150"
    assert f"{lead_factor(20, 2, 0.985):.3f}" == "1.069"


def test_lead_part_and_drum_end_factors_of_random_reevings_follow_from_the_efficiency_of_each_sheave() -> None:
    draw = random.Random(14)
    for _ in range(200):
        ends, n, efficiency = draw.choice((1, 2)), draw.randint(1, 16), draw.uniform(0.9, 1.0)
        each = parts(n, efficiency)
        assert lead_factor(ends * n, ends, efficiency) == pytest.approx(max(each), rel=EXACT)
        assert drum_end_factor(ends * n, ends, efficiency, hoisting=True) == pytest.approx(each[0], rel=EXACT)
        assert drum_end_factor(ends * n, ends, efficiency, hoisting=False) == pytest.approx(each[-1], rel=EXACT), (
            "lowering turns the series round: the dead end carries most, the drum end least"
        )
    assert lead_factor(20, 2, 1.0) == 1.0


def test_lead_part_tensions_agree_with_the_wire_rope_users_manual() -> None:
    """Wire Rope Technical Board, 4th edition, page 88: 4 parts, plain bearings (1.09 a sheave), one to the drum."""
    sheave = 1.09
    factor = lead_factor(4, 1, 1.0 / sheave) / 4 * sheave
    assert factor == pytest.approx(0.309, abs=TABLE)
    assert 0.309 * sheave * sheave == pytest.approx(0.367, abs=TABLE), "with two sheaves more"
    assert factor * sheave * sheave * 6000 == pytest.approx(2202, abs=6), "[lb], of a load of 6000 lb"


def test_the_verdict_on_a_rope_depends_on_its_drum_ends_and_states_the_assumptions() -> None:
    two = str(check(bare("lift", [*HEAVY, *crane(sheave_efficiency="98.5 %")])))
    assert "20 falls, 2 drum ends, sheave efficiency 0.985: lead part 1.069 of the mean" in two
    with pytest.raises(SceneError) as refusal:
        bare("lift", [*HEAVY, *crane(sheave_efficiency="98.5 %", drum_ends="1")])
    message = str(refusal.value)
    assert "rope factor of crane.H3 would be 5.30; at least 5.60 is needed (ISO 4308-1" in message
    assert "20 falls, 1 drum end, sheave efficiency 0.985: lead part 1.150 of the mean)" in message


def test_the_required_rope_factor_follows_from_the_mechanism_group_and_its_standard() -> None:
    scene = bare("lift", crane(mechanism_group="M4"))
    rows = [limit for limit in scene.plan.limits if limit.quantity == "rope factor"]
    assert {(limit.value, limit.source) for limit in rows} == {
        (4.0, "ISO 4308-1 (withdrawn for ISO 16625), Zp of running ropes, M4")
    }
    with pytest.raises(SceneError, match=r"would be 18\.76; at least 20\.00 is needed \(the scene"):
        bare("lift", crane(rope_factor="20", drum_ends="1", sheave_efficiency="98.8 %"))


def test_a_hoist_rope_with_an_odd_number_of_falls_on_two_drum_ends_is_refused() -> None:
    with pytest.raises(SceneError, match="15 falls cannot be shared by 2 drum ends: give an even number"):
        bare("lift", crane(falls="15", drum_ends="2"))
    assert cranes(bare("lift", crane(falls="15", drum_ends="1")).plan)[0].hooks[0].drum_ends == 1


def test_the_tension_at_the_drum_end_includes_the_weight_of_the_rope(tmp_path: Path) -> None:
    """A run with massive ropes knows the tension of each end; without, the upper one is reckoned from the lower."""
    settings = ["end=14 s", *crane(sheave_efficiency="100 %", drum_pull="1 MN")]
    scene = bare("lift", [*settings, "fidelity={ropes: massive, lumps: 4}"])
    run(scene, tmp_path / "massive.mcap", in_process=True)
    tension = Recording(tmp_path / "massive.mcap").signal("rope/tension")
    top, hook = tension["crane.H3~1"], tension["crane.H3"]
    rope = next(hook for hook in cranes(scene.plan)[0].hooks if hook.rope == "crane.H3")
    own = rope.line * G * 64.7  # [N] of 64.7 m
    assert float((top - hook).mean()) == pytest.approx(own, rel=5e-3), "vibrations of the rope cancel in the mean"
    massless = bare("lift", settings)
    pull = next(use for use in massless.uses if use.limit.quantity == "drum pull" and use.limit.subject == "crane.H3")
    carried = max(state.tensions["crane.H3"] for state in massless.states)
    assert pull.value == pytest.approx((carried + own) / 20, rel=1e-3)


def test_a_lift_that_exceeds_the_drum_pull_is_refused() -> None:
    with pytest.raises(SceneError, match=r"drum pull of crane.H3 would be 109.4 kN, 109 %; 100 kN is allowed"):
        bare("lift", crane(drum_pull="100 kN"))


@pytest.mark.parametrize("ropes", ["ropes: rigid", "rope mass: lumped", "ropes: massive, lumps: 2"])
def test_the_checks_of_a_rope_do_not_depend_on_its_model_level(ropes: str, tmp_path: Path) -> None:
    """A tension is that at the hook, whatever the rope weighs in the model: its weight is reckoned once."""
    rows = []
    for model in ("ropes: elastic", ropes):
        run(bare("lift", ["end=5 s", f"fidelity={{{model}}}"]), tmp_path / "lift.mcap", in_process=True)
        found = verdict_of(Recording(tmp_path / "lift.mcap"))
        assert found is not None
        cells = {row[1]: row[3].split()[0] for row in found.tables[0].rows if row[3]}
        rows.append([float(cells[quantity]) for quantity in ("hook load", "rope factor", "drum pull")])
    assert rows[0] == pytest.approx(rows[1], rel=0.01), "the ramp of the winch adds a little more where ropes stretch"
    assert rows[0][0] == pytest.approx(20.3, abs=0.2), "[t] of the loader below its hook block"


@pytest.mark.parametrize("name", ["jib", "crawler", "hall", "spreader", "floating", "lift"])
def test_the_hoist_rope_of_every_crane_type_has_a_weight_and_a_rating(name: str) -> None:
    """What its drum end pulls is the lead part of what hangs there, and the own weight of a fall."""
    scene = load(name)
    pulls = {use.limit.subject: use.value for use in scene.uses if use.limit.quantity == "drum pull"}
    hooks = [hook for machine in scene.plan.machines for hook in machine.hooks if hook.rope in pulls]
    assert hooks
    for hook in hooks:
        lead = drum_end_factor(hook.falls, hook.drum_ends, hook.efficiency, hoisting=True) / hook.falls
        lengths = {rope.name: rope.L0 for machine in scene.plan.machines for rope in machine.system.ropes}
        most = max(state.tensions[hook.rope] for state in scene.statics.states)
        own = hook.line / hook.falls * G * lengths[hook.rope]
        assert lead * most + 0.1 * own < pulls[hook.rope] < lead * most + 2.0 * own
        assert hook.rated > most
