"""The scenes that come with heavylift: their sizes, their geometry, their static loads."""

import math
import subprocess
import sys

import pytest
from heavylift.nodes.plan import plan
from heavylift.nodes.scene import bundled, check, load, parse
from heavylift.nodes.scene.keys.parts import place, poses
from lifting import cranes, hook_ropes, machine, pose, slings

SIZES = {  # bodies, degrees of freedom, ropes, slings, models, actions
    "arm": (4, 4, 0, 0, 2, 0),
    "crawler": (6, 12, 1, 4, 3, 9),
    "damper": (4, 8, 0, 0, 3, 2),
    "dock": (7, 12, 1, 4, 4, 6),
    "edge": (9, 24, 3, 4, 4, 7),
    "emergency-stop": (10, 30, 3, 6, 6, 6),
    "floating": (11, 12, 1, 4, 4, 7),
    "girder": (4, 3, 0, 0, 2, 3),
    "gust": (1, 6, 1, 0, 2, 0),
    "hall": (4, 12, 1, 4, 3, 7),
    "in-turn": (12, 24, 2, 8, 7, 20),
    "jib": (5, 12, 1, 4, 3, 9),
    "lift": (10, 30, 3, 6, 6, 5),
    "linkage": (3, 1, 0, 0, 2, 4),
    "moored": (6, 18, 1, 4, 5, 6),
    "pendulum": (1, 1, 0, 0, 2, 0),
    "ramp": (1, 6, 0, 0, 2, 0),
    "single-turn": (10, 30, 3, 6, 6, 18),
    "sling-break": (10, 30, 3, 9, 6, 6),
    "snatch": (1, 1, 1, 0, 2, 2),
    "spreader": (10, 30, 3, 5, 7, 5),
    "tackle": (1, 1, 1, 0, 2, 4),
    "tandem": (15, 40, 4, 8, 8, 5),
    "trolley": (2, 4, 0, 0, 2, 4),
    "turnover": (19, 54, 6, 12, 10, 23),
    "turnover-untuned": (19, 54, 6, 12, 10, 23),
    "wind-tandem": (15, 40, 4, 8, 9, 5),
    "yard": (12, 36, 3, 12, 7, 22),
}


def test_every_bundled_scene_is_listed() -> None:
    assert sorted(bundled()) == sorted(SIZES)


@pytest.mark.parametrize("name", [pytest.param(x, marks=[pytest.mark.large] if x == "ramp" else []) for x in SIZES])
def test_a_bundled_scene_has_its_documented_size(name: str) -> None:
    scene = load(name)
    message = check(scene)
    assert (message.bodies, message.dof, message.ropes, message.slings, message.models, message.actions) == SIZES[name]
    assert scene.text == bundled()[name].read_text(encoding="utf-8")
    assert plan.decode(plan.encode(scene.plan)) == scene.plan


def test_the_scene_turnover_hangs_in_equilibrium_at_the_start() -> None:
    built = load("turnover").plan
    ropes = hook_ropes(built)
    strain = 45e3 * built.gravity / (20 * 93.5088e6)
    for name, stretched in {"west.H1": 84.3, "west.H3": 42.7, "east.H2": 84.3, "east.H3": 42.7}.items():
        assert ropes[name].L0 * (1 + strain) == pytest.approx(stretched, abs=1e-12)
    assert pose(built, "loader-1.upper")[:3] == pytest.approx((34.0, 60.4, 17.7))
    assert pose(built, "loader-6.upper")[:3] == pytest.approx((76.0, 87.0, 45.3))
    assert [crane.cells[0].capacity for crane in cranes(built)] == [675e3, 675e3]
    assert pose(built, "block") == pytest.approx((58.0, 75.0, 6.995, 0.0, 0.0, 0.0, 1.0))
    block = machine(built, "block")
    assert [s.name in block.closed for s in block.system.supports] == [True] * 4 + [False] * 4
    beams = {name: (tie.upper.p, tie.lug) for name, (tie, _) in slings(built).items()}
    assert beams["loader-2.sling-1"] == ((-2.0, 0.0, -1.0), "A3")
    assert beams["loader-2.sling-2"] == ((2.0, 0.0, -1.0), "A4")


def test_the_equilibrium_path_of_the_scene_turnover_covers_all_stages() -> None:
    message = load("turnover").statics
    at = {state.stage: state for state in message.states}  # the last of each
    expected = {  # rope A, rope B, trolley A, trolley B
        "hoist": (61.0, 19.4, 60.4, 87.0),
        "re-rig, hooks up": (46.4, 34.2, 75.0, 80.6),
        "take up C to length": (46.4, 37.0, 75.0, 69.4),
        "turn to 180 degrees": (61.0, 19.4, 89.6, 63.0),
    }
    for stage, expected_values in expected.items():
        state = at[stage]
        found = [state.references[name] for name in ("west.H1", "east.H3")]
        found += [state.coordinates[name] for name in ("west.upper-slide", "east.lower-slide")]
        assert found == pytest.approx(expected_values, abs=2e-3), stage
    last = message.states[-1]
    assert last.grounded
    place, _ = last.poses["block"]
    assert place == pytest.approx((178.0, 75.0, 6.995), abs=0.03), "dragged a little as ropes of two lengths give way"
    assert message.known


def test_the_static_report_of_the_scene_turnover_shows_its_utilisations() -> None:
    page = str(check(load("turnover")))
    assert page.startswith("turnover: 19 bodies, 54 degrees of freedom, 6 ropes, 12 slings, 10 models, 23 actions")
    for line in (
        "load                            101.6    101.6    246.8    101.6    101.6    246.8",
        "load of the rope [t]           270.0    270.0    291.9",
        "6 hooks carry the block: their shares are statically indeterminate",
    ):
        assert line in page


def test_the_static_report_of_the_scene_turnover_shows_the_stages_that_change_its_loads() -> None:
    lines = str(check(load("turnover"))).splitlines()
    assert lines[4:17] == [
        "  static sling load [t]         east.H1  east.H2  east.H3  west.H1  west.H2  west.H3",
        "  load                            101.6    101.6    246.8    101.6    101.6    246.8",
        "  hoist                           101.6    101.6    246.9    101.6    101.6    246.9",
        "  turn to 90 degrees, 30 deg      115.0    115.0    220.1    115.0    115.0    220.1",
        "  turn to 90 degrees, 60 deg      134.7    134.7    180.6    134.7    134.7    180.6",
        "  turn to 90 degrees, 90 deg      218.2    218.2     13.6    218.2    218.2     13.6",
        "  slacken B                       225.0    225.0      0.0    225.0    225.0      0.0",
        "  take up C to length             218.2    218.2     13.6    218.2    218.2     13.6",
        "  turn to 180 degrees, 120 deg    134.7    134.7    180.6    134.7    134.7    180.6",
        "  turn to 180 degrees, 150 deg    115.0    115.0    220.1    115.0    115.0    220.1",
        "  turn to 180 degrees, 180 deg    101.6    101.6    246.9    101.6    101.6    246.9",
        "  lower                           101.6    101.6    246.8    101.6    101.6    246.8",
        "",
    ]


def test_an_eccentric_centre_of_mass_shifts_the_loads_of_the_scene_turnover() -> None:
    text = bundled()["turnover"].read_text(encoding="utf-8")
    scene = parse(text.replace("  supports:", "  com: [0.8 m, 0 m, 0 m]\n  supports:", 1))
    hooks = [f"{crane}.H{i}" for crane in ("west", "east") for i in (1, 2, 3)]
    loads = {row.hook: row.sling_load for row in check(scene).rows if row.stage == "hoist"}
    tonnes = [loads[hook] / 1e3 for hook in hooks]
    assert tonnes == pytest.approx([93, 97, 241, 106, 110, 253], abs=1.0)


def test_the_four_link_arm_starts_in_the_published_state() -> None:
    system = load("arm").plan.machines[0].system
    at = poses(system)
    tip = at["link-4"][0] + at["link-4"][1] @ (1.0, 0.0, 0.0)
    angles = (0.3, -0.4, 0.1)
    lengths = (2.0, 1.6, 1.0)
    assert tip == pytest.approx(
        (
            sum(l * math.cos(a) for l, a in zip(lengths, angles, strict=True)),
            0.0,
            sum(l * math.sin(a) for l, a in zip(lengths, angles, strict=True)),
        )
    )
    assert [body.inertia[1][1] for body in system.bodies] == pytest.approx([400 / 3, 18.0, 160 / 3, 10.0])


def test_ropes_and_supports_of_a_mechanism_carry_load_from_the_start() -> None:
    scene = parse("""\
heavylift: 1
name: hanging
end: 1 s
mechanism:
  bodies:
    load: {mass: 1 t}
    post: {mass: 1 t}
  joints:
    slide: {type: prismatic, child: load, axis: [0, 0, 2], start: 5 m}
    foot: {type: prismatic, child: post, axis: [0, 0, 1], start: -1 mm}
  ropes:
    taut: {start: {body: world, at: [0, 0, 10 m]}, end: {body: load}, EA: 1 MN, length: 4.9 m}
    slack: {start: {body: world, at: [0, 0, 10 m]}, end: {body: load}, EA: 1 MN, length: 5.1 m}
  supports:
    pad: {body: post, height: 0 m, stiffness: 10 MN/m}
    beside: {body: load, height: 0 m, stiffness: 10 MN/m}
""")
    mechanism = scene.plan.machines[0]
    assert (mechanism.taut, mechanism.closed) == (("taut",), ("pad",))
    assert place(mechanism.system.ropes[0].lines[0].b, poses(mechanism.system)) == pytest.approx((0, 0, 5))


def test_a_node_process_that_only_decodes_the_plan_imports_few_modules() -> None:
    code = "import sys, heavylift.nodes.plan.plan; print({'pydantic', 'ruamel.yaml', 'numpy'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"
