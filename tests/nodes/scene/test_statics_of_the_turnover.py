"""The kernel's statics reproduce the planning table of `turnover`: load shares and stability at every angle.

Ropes and trolleys take the lengths and places of the plan for an angle (requirements, section 6), the block starts near
it, and where it comes to rest is the kernel's answer.  Elasticity shifts the angle by up to half a degree, so shares
are compared at the angle that was found.
"""

import numpy as np
import pytest
from heavylift.kernel.analysis import equilibrium
from heavylift.kernel.simulation import Simulation
from heavylift.nodes.models import system
from heavylift.nodes.scene import load
from scipy.spatial.transform import Rotation

SHARE = 0.005  # of the load
LOAD = 900.0e3 * 9.80665
A, B = (1, 2, 4, 5), (3, 6)
LOADED = 35.0e3 + 10.0e3  # [kg] loader with hook block


def held(degrees: float, more: float = 0.0) -> Simulation:
    """The yard with the block near an angle of the first half, all slings hooked; B's ropes `more` metres longer."""
    simulation = Simulation(system(load("turnover", []).plan))
    simulation.start()
    t, z = np.radians(degrees), 30.0
    y_A, z_A = -14.6 * np.cos(t), 14.6 * np.sin(t)
    y_B, z_B = 12.0 * np.cos(t) + 5.6 * np.sin(t), -12.0 * np.sin(t) + 5.6 * np.cos(t)
    L_A, L_B = 102.0 - (z + z_A + 11.0), 88.0 - (z + z_B + 33.0) + more
    graph, state = simulation.program.graph, simulation.state
    for crane in ("west", "east"):
        for slide, y in (("upper", y_A), ("lower", y_B)):
            state[graph.joint(f"{crane}.{slide}-slide").q] = 75.0 + y
            simulation.references.set_value(f"{crane}.{slide}-slide.drive", 0, 75.0 + y)
        for hook, L in (("H1", L_A), ("H2", L_A), ("H3", L_B)):
            simulation.references.set_value(f"{crane}.{hook}", 0, L)
    turned = Rotation.from_rotvec([-t, 0.0, 0.0]).as_quat()
    state[graph.joint("block.free").q] = [58.0, 75.0, z - 0.1, *turned]
    for i in (*A, *B):
        at = graph.joint(f"loader-{i}.free").q
        y, L, top = (y_A, L_A, 102.0) if i in A else (y_B, L_B, 88.0)
        state[at.start + 1 : at.start + 3] = 75.0 + y, top - L
    return simulation


def slings(tensions: dict[str, float], loaders: tuple[int, ...]) -> float:
    return sum(T for name, T in tensions.items() for i in loaders if name.startswith(f"loader-{i}."))


@pytest.mark.parametrize("degrees", [0.0, 30.0, 60.0, 85.0])
def test_load_shares_of_the_scene_turnover_agree_with_the_tabulated_plan(degrees: float) -> None:
    simulation = held(degrees)
    found = equilibrium(simulation)
    x, y, z, w = found.q[simulation.program.graph.joint("block.free").q][3:]
    t = np.radians(degrees)
    assert 2.0 * np.arctan2(-x, w) == pytest.approx(t, abs=np.radians(0.5))
    assert (y, z) == pytest.approx((0.0, 0.0), abs=1e-6)
    t = 2.0 * np.arctan2(-x, w)
    a, b = -14.6 * np.cos(t), 12.0 * np.cos(t) + 5.6 * np.sin(t)
    assert slings(found.tensions, B) / LOAD == pytest.approx(-a / (b - a), abs=SHARE)
    assert slings(found.tensions, A) / LOAD == pytest.approx(b / (b - a), abs=SHARE)
    assert all(T > 0.0 for T in found.tensions.values())


def test_at_90_degrees_with_crane_b_lowered_the_block_hangs_from_crane_a_alone() -> None:
    found = equilibrium(held(90.0, more=0.2))
    assert slings(found.tensions, B) == 0.0
    assert [found.tensions[f"{c}.{h}"] for c in ("west", "east") for h in ("H1", "H2")] == pytest.approx(
        [LOAD / 4.0 + LOADED * 9.80665] * 4, rel=1e-6
    )
