"""A hook lifts several blocks in random order: hook and slings carry the hooked block only."""

from __future__ import annotations

from math import hypot, sqrt
from pathlib import Path
from random import Random
from typing import NamedTuple

import pytest
from heavylift.coordinator.run import Result, run
from heavylift.coordinator.run.simulate import simulate
from heavylift.nodes.scene import LoadedScene, parse

G, HOOK_kg = 9.80665, 2500.0  # of the hook block of `overhead-100`
LENGTH_m, EA_N = 6.0, 120e6
BLOCKS, APART_m = "ABC", 9.0
AT_REST = 1e-4  # of a tension: the equilibrium is sought to the stiffness of supports, 1e-6, and of the rope's mass
IN_MOTION = 1e-3  # the mean over whole swings to and fro, which is above mg by half the square of their angle
BALANCE = (
    1e-4  # of the work: a tenth of what the scene asks for; a block that hung on one rope too many would leave 1e-2
)


class Lug(NamedTuple):
    """Where the four lugs of a block are, from its middle [m], and its mass [kg]."""

    x: float
    y: float
    mass: float

    @property
    def sling(self) -> float:
        """Tension of each of four slings that bear the block [N], by its own stretch."""
        tension = 0.0
        for _ in range(20):
            long = LENGTH_m * (1.0 + tension / EA_N)
            tension = self.mass * G / 4.0 * long / sqrt(long**2 - hypot(self.x, self.y) ** 2)
        return tension


def drawn(seed: int) -> tuple[dict[str, Lug], list[str], str]:
    """Blocks, the order in which they are lifted, and the text of the scene."""
    draw = Random(seed)
    blocks = {name: Lug(*(draw.uniform(1.2, 2.4) for _ in range(2)), draw.uniform(10e3, 80e3)) for name in BLOCKS}
    order = draw.sample(BLOCKS, len(BLOCKS))
    order.append(draw.choice(order[:-1]))  # which hangs on its old slings or on new ones
    rows, actions = "", ""
    for i, (name, (x, y, mass)) in enumerate(blocks.items()):
        lugs = f"{{a: [-{x} m, {y} m, 2 m], b: [{x} m, {y} m, 2 m], c: [-{x} m, -{y} m, 2 m], d: [{x} m, -{y} m, 2 m]}}"
        supports = "{height: 0.5 m, at: [[-2 m, -2 m], [2 m, -2 m], [-2 m, 2 m], [2 m, 2 m]]}"
        where = f"size: [6 m, 5 m, 4 m], at: [{APART_m * i} m, 8 m, 2.5 m]"
        rows += f"  {name}: {{mass: {mass} kg, {where}, lugs: {lugs}, supports: {supports}}}\n"
    at = BLOCKS.index(order[0])
    start = APART_m * at
    for k, name in enumerate(order):
        by, at = APART_m * (BLOCKS.index(name) - at), BLOCKS.index(name)
        if k:
            actions += f"  - hall travelling: travel 20 m/min ramp one swing by {by} m\n"
            actions += "  - hall: lower 4 m/min by 2 m\n"
            actions += f"  - legs: hook [{', '.join(f'{name}.{lug}' for lug in 'abcd')}]\n"
        actions += f"  - hall: hoist 0.5 m/min until {name} lifted\n"
        actions += f"  - {{stage: carry {k}, hall: hoist 1 m/min by 0.4 m}}\n"
        actions += f"  - {{stage: stand {k}, wait: 20 s}}\n"
        actions += f"  - hall: lower 0.5 m/min until {name} landed and all slings slack\n"
        actions += "  - legs: unhook\n  - hall: hoist 4 m/min by 1.5 m\n"
    hung = ", ".join(f"{order[0]}.{lug}" for lug in "abcd")
    text = f"""\
heavylift: 1
name: turns
accuracy: 0.1 %
samples: 5 Hz
blocks:
{rows}cranes: {{hall: {{type: overhead-100, at: {start} m, trolley: 8 m}}}}
rigging: {{legs: {{on: hall main, to: [{hung}], length: {LENGTH_m} m, sling: {{EA: {EA_N} N}}}}}}
actions:
{actions}"""
    return blocks, order, text


def carried(scene: LoadedScene, k: int) -> dict[str, float]:
    """Tensions [N] of what bears something, at rest where the block hangs for the k-th time."""
    states = [state for state in scene.statics.states if state.stage == f"carry {k}"]
    return {name: tension for name, tension in states[-1].tensions.items() if tension > 0.0}


def energy(result: Result, name: str, k: int) -> float:
    """An energy of the sample k [J]."""
    signal = result["energy"]
    return float(signal.values[k, signal.names.index(name)])


def height(result: Result, blocks: dict[str, Lug], k: int) -> float:
    """What all that is lifted has against the ground [J], by where it is."""
    masses = {"hall.main": HOOK_kg} | {name: block.mass for name, block in blocks.items()}
    return sum(m * G * float(result[f"pose/{name}"].values[k, 2]) for name, m in masses.items())


@pytest.mark.parametrize("seed", range(4))
def test_a_hook_that_lifts_several_blocks_in_turn_has_for_each_the_loads_of_a_single_lift(seed: int) -> None:
    blocks, order, text = drawn(seed)
    scene = parse(text)
    assert not scene.findings
    result = simulate(scene)
    for k, name in enumerate(order):
        own = "" if name == order[0] else f".{name}-"  # slings are named by where they hang but for the first block
        expected = {"hall.main": (blocks[name].mass + HOOK_kg) * G}
        for i, lug in enumerate("abcd", 1):
            expected[f"legs.sling-{i}{own}{lug if own else ''}"] = blocks[name].sling
        assert carried(scene, k) == pytest.approx(expected, rel=AT_REST)
        span = next(stage for stage in result.stages if stage.name == f"stand {k}")
        tension = result["rope/tension"]
        there = (tension.t > span.start) & (tension.t < span.start + 20.0)
        mean = dict(zip(tension.names, tension.values[there].mean(axis=0), strict=True))
        borne = {name: x for name, x in mean.items() if x > 0.0}
        assert borne == pytest.approx(expected, rel=IN_MOTION)
        at = int(there.nonzero()[0][-1])
        done = energy(result, "work", at)
        gained = height(result, blocks, at) - height(result, blocks, 0)
        gained += sum(energy(result, part, at) - energy(result, part, 0) for part in ("stored", "kinetic", "heat"))
        most = max(abs(energy(result, "work", n)) for n in range(at + 1))
        assert done == pytest.approx(gained, abs=BALANCE * most)


def test_a_run_with_several_blocks_has_one_digest_in_one_and_in_several_processes(tmp_path: Path) -> None:
    scene = parse(drawn(0)[2])
    message = [run(scene, tmp_path / f"{where}.mcap", in_process=where) for where in (True, False)]
    assert message[0].digest == message[1].digest
    assert message[0].verdict is not None
    assert " 0 red, 0 undecided" in message[0].verdict.line
