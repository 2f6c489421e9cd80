"""A flexible block: deflection by beam theory, load shares of slings, modes from tables, rigid limit."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from math import pi
from pathlib import Path

import numpy as np
import pytest
from heavylift import simulate
from heavylift.coordinator.participants import resting
from heavylift.kernel import SceneError
from heavylift.kernel.description import Body
from heavylift.kernel.multibody.flexible import modes_of, reduced
from heavylift.nodes.plan import block_body
from heavylift.nodes.scene import LoadedScene, load, parse
from lifting import body

L, MASS, EI, G = 40.0, 150e3, 6e9, 9.80665
SLING, FALLS = 445e6, 12 * 38.3e6  # EA of a sling and of all falls of a hook [N]
SCENE = """\
heavylift: 1
name: bends
samples: 20 Hz
block:
  mass: 150 t
  size: [40 m, 6 m, 3 m]
  at: [0 m, 12 m, 2.5 m]
  lugs: {lugs}
  supports: {{height: 1 m, at: [[-14 m, -2 m], [14 m, -2 m], [-14 m, 2 m], [14 m, 2 m]]}}
  {bends}
cranes: {cranes}
rigging: {rigging}
actions:
  - all hooks: hoist 1 m/min until all slings taut
  - all hooks: hoist 1 m/min until lifted
  - stage: up
    all hooks: hoist 3 m/min by 1 m
  - wait: 5 s
"""
BEAM = "beam: {EI y: 6 GN m2, modes: 4, damping: 2 %, loads: [-12 m, 12 m]}"


def written(bends: str, places: tuple[float, ...] = (-12.0, 12.0)) -> str:
    """The block on a hall crane above each of these places along it."""
    lugs, cranes, rigging = ({} for _ in range(3))
    for i, x in enumerate(places):
        lugs[f"L{i}"] = f"[{x} m, 0 m, 1.5 m]"
        cranes[f"c{i}"] = f"{{type: overhead-100, at: {x} m, trolley: 12 m}}"
        rigging[f"r{i}"] = f"{{on: c{i} main, to: [L{i}], length: 4 m, slack: 0.1 m}}"
    words = (f"{{{', '.join(f'{k}: {v}' for k, v in x.items())}}}" for x in (lugs, cranes, rigging))
    lugs, cranes, rigging = words
    return SCENE.format(lugs=lugs, cranes=cranes, rigging=rigging, bends=bends)


@cache
def hung(bends: str = BEAM, places: tuple[float, ...] = (-12.0, 12.0)) -> LoadedScene:
    """That scene."""
    return parse(written(bends, places))


def sagged(at: tuple[float, ...], places: tuple[float, ...], forces: Sequence[float], weighs: bool) -> np.ndarray:
    """Deflections `at` places along the beam, less its mean motion, under forces at places or the weight, balanced by
    the inertia of a rigid beam: four quadratures (Euler, Bernoulli)."""
    x = np.linspace(-L / 2, L / 2, 20001)
    h = x[1] - x[0]
    weight = MASS * G / L if weighs else 0.0
    lift, turn = sum(forces) - weight * L, sum(f * a for f, a in zip(forces, places, strict=True))
    u = -weight - lift / L - 12.0 * turn / L**3 * x
    for k in range(4):
        u = np.concatenate([[0.0], np.cumsum((u[1:] + u[:-1]) * h / 2.0)])
        if k == 0:
            u += sum(f * np.clip((x - a) / h + 0.5, 0.0, 1.0) for a, f in zip(places, forces, strict=True))
    u = u / EI
    u -= np.average(u, weights=[0.5, *[1.0] * (len(x) - 2), 0.5])
    return np.interp(at, x, u - (u @ x) / (x @ x) * x)


def deflections(scene: LoadedScene, places: tuple[float, ...]) -> list[float]:
    """Along z within the block as it hangs at the end."""
    modes = modes_of("block", body(scene.plan, "block").flexible)
    eta = np.array(scene.statics.states[-1].modes["block"])
    return [float(modes.at(x)[2] @ eta) for x in places]


def test_a_flexible_block_on_two_slings_sags_by_beam_theory() -> None:
    scene, places = hung(), (-20.0, -12.0, 0.0, 12.0, 20.0)
    expected = sagged(places, (-12.0, 12.0), [MASS * G / 2] * 2, weighs=True)
    assert expected[0] == pytest.approx(9.415e-3, rel=1e-4)
    assert deflections(scene, places) == pytest.approx(expected, rel=3e-3)
    assert scene.statics.states[-1].tensions["r0.sling-1"] == pytest.approx(MASS * G / 2, rel=1e-6)


def test_four_slings_share_a_flexible_block_by_their_stiffnesses_and_its_own() -> None:
    """Compatibility: each sling with its rope is a spring between a hook and the bent axis; all hooks hang alike."""
    places = (-15.0, -5.0, 5.0, 15.0)
    scene = hung("beam: {EI y: 6 GN m2, modes: 4, damping: 2 %, loads: [-15 m, -5 m, 5 m, 15 m]}", places)
    last = scene.statics.states[-1]
    weight = sagged(places, places, [0.0] * 4, weighs=True)
    unit = np.array([sagged(places, places, f, weighs=False) for f in np.eye(4)]).T
    soft = np.diag([1.0 / (SLING / 4.0) + last.references[f"c{i}.main"] / FALLS for i in range(4)])
    A = np.zeros((6, 6))
    A[:4, :4], A[:4, 4], A[:4, 5] = unit + soft, 1.0, places
    A[4, :4], A[5, :4] = 1.0, places
    hooks = np.array([last.references[f"c{i}.main"] for i in range(4)])
    dead = 2.5e3 * G * hooks / FALLS  # by which hook blocks stretch the ropes
    found = np.linalg.solve(A, [*(-weight - (hooks - hooks[0]) - (dead - dead[0])), MASS * G, 0.0])[:4]
    tensions = [last.tensions[f"r{i}.sling-1"] for i in range(4)]
    assert tensions == pytest.approx(found, rel=2e-3)
    assert max(tensions) / min(tensions) > 1.05  # a rigid block would load all alike


def test_a_flexible_block_on_two_springs_has_its_natural_frequency() -> None:
    """Against the eigenvalues of another finite-element model: Hermite beam, slings, hook blocks, ropes."""
    scene = hung()
    path = resting(scene, "up")
    ropes = [scene.statics.states[-1].references[f"c{i}.main"] for i in range(2)]
    n = 41
    h = L / (n - 1)
    M, K = np.zeros((2 * n + 2,) * 2), np.zeros((2 * n + 2,) * 2)
    for e in range(n - 1):
        at = np.ix_(*[range(2 * e, 2 * e + 4)] * 2)
        own = [[156, 22 * h, 54, -13 * h], [22 * h, 4 * h * h, 13 * h, -3 * h * h]]
        own += [[54, 13 * h, 156, -22 * h], [-13 * h, -3 * h * h, -22 * h, 4 * h * h]]
        M[at] += MASS / L * h / 420 * np.array(own)
        bend = [[12, 6 * h, -12, 6 * h], [6 * h, 4 * h * h, -6 * h, 2 * h * h]]
        bend += [[-12, -6 * h, 12, -6 * h], [6 * h, 2 * h * h, -6 * h, 4 * h * h]]
        K[at] += EI / h**3 * np.array(bend)
    for i, x in enumerate((-12.0, 12.0)):
        lug, hook = 2 * round((x + L / 2) / h), 2 * n + i
        M[hook, hook] = 2.5e3
        K[np.ix_([lug, hook], [lug, hook])] += SLING / 4.0 * np.array([[1, -1], [-1, 1]])
        K[hook, hook] += FALLS / ropes[i]
    expected = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real)) / (2.0 * pi)
    found = np.array([m.frequency for m in path.modes().oscillations])
    for f in expected[[0, 2, 3, 4]]:  # not the second, of tilting, to which the block's height adds
        assert found[np.argmin(np.abs(found - f))] == pytest.approx(f, rel=2e-3)


def test_modes_of_a_block_from_a_table_have_their_stated_stiffness() -> None:
    """One bending mode: 2 T phi / (m w^2) of the lugs."""
    phi = -0.0997
    words = f"{{frequency: 1.5 Hz, mass: 37.5 t, damping: 2 %, shape: {{L0: [0, 0, {phi}], L1: [0, 0, {phi}]}}}}"
    scene = hung(f"modes: {{sag: {words}}}")
    (eta,) = scene.statics.states[-1].modes["block"]  # of a shape of largest displacement 1
    stiffness = 37.5e3 * (2.0 * pi * 1.5) ** 2
    assert abs(eta) == pytest.approx(MASS * G * phi * phi / stiffness, rel=1e-6)


def test_modes_of_a_block_are_read_from_a_table(tmp_path: Path) -> None:
    rows = "block,mode,place,x,y,z,frequency [Hz],mass [t],damping [%]\n"
    rows += (
        "B17,sag,L0,0,0,1,1.5,37.5,2\nB17,sag,L1,0,0,0.9,,,\nB17,twist,lower-1,0,0.1,1,4,20,\nB18,sag,L0,0,0,1,9,9,\n"
    )
    (tmp_path / "modes.csv").write_text(rows)
    (tmp_path / "scene.yaml").write_text(written("modes from: modes.csv#B17"))
    modal = body(load(tmp_path / "scene.yaml").plan, "block").flexible.modal
    assert modal.nodes == ((-12.0, 0.0, 1.5), (12.0, 0.0, 1.5), (-14.0, -2.0, -1.5))
    assert modal.shapes == (((0, 0, 1), (0, 0, 0.9), (0, 0, 0)), ((0, 0, 0), (0, 0, 0), (0, 0.1, 1)))
    assert (modal.frequency, modal.mass, modal.damping) == ((1.5, 4.0), (37.5e3, 20e3), (0.02, 0.0))
    (tmp_path / "modes.csv").write_text(rows.replace("0.9,,,", "0.9,1.6,,"))
    with pytest.raises(SceneError, match=r"modes.csv:3:.*a mode has one frequency, and 'sag' has 1.5 Hz, too"):
        load(tmp_path / "scene.yaml")


def test_a_flexible_block_without_modes_equals_the_rigid_block() -> None:
    rigid, stiff = hung(""), hung("beam: {EI y: 6 GN m2, modes: 0}")
    a, b = (scene.statics.states[-1] for scene in (rigid, stiff))
    assert a.tensions == pytest.approx(b.tensions, rel=1e-9, abs=1e-3)
    softer, harder = hung(), hung("beam: {EI y: 6000 GN m2, modes: 4, loads: [-12 m, 12 m]}")
    u, v = (deflections(scene, (0.0,))[0] for scene in (softer, harder))
    assert v == pytest.approx(u / 1000.0, rel=5e-3)


def test_modelling_a_block_as_flexible_keeps_its_mass_and_inertia() -> None:
    """Whatever part of a block bends, and wherever its centre of mass is."""
    from heavylift.kernel.description import Beam, Flexible

    random = np.random.default_rng(5)
    for _ in range(10):
        mass, length, part = random.uniform(1e5, 9e5), random.uniform(10.0, 60.0), random.uniform(0.2, 0.9)
        com, moments = tuple(random.uniform(-1.0, 1.0, 3)), tuple(random.uniform(1e8, 2e8, 3))
        beam = Beam(length, part * mass / length, 1e10, polar=1e5, elements=4, start=-length / 2)
        flexible = Flexible(0, beam, frame="free")
        made = block_body(Body("b", mass, com, tuple(map(tuple, np.diag(moments)))), flexible)
        J = reduced(modes_of("b", flexible)).J0
        c, d = np.array(com), np.array(made.com)
        whole = np.diag(moments) + mass * ((c @ c) * np.eye(3) - np.outer(c, c))
        rest = np.array(made.inertia) + made.mass * ((d @ d) * np.eye(3) - np.outer(d, d))
        assert rest + J[:3, :3] == pytest.approx(whole, rel=1e-9, abs=1e-3)
        assert (made.mass + J[5, 5], made.mass * d) == (pytest.approx(mass), pytest.approx(mass * c))


def test_a_run_records_and_reports_the_deflection_of_a_flexible_block() -> None:
    result = simulate(hung())
    message = [f.sentence for f in result.verdict.findings if f.quantity == "bending"]
    bent = result["deflection"]
    assert bent.unit == "m"
    assert bent.names[:3] == ["block.L0.x", "block.L0.y", "block.L0.z"]
    begins = {name: bent[name][0] for name in ("block.middle.z", "block.end-1.z")}
    assert begins["block.middle.z"] < -0.02 < 0.03 < begins["block.end-1.z"]  # on its supports near the ends
    assert message == [f"block bends most at end-1, by {1e3 * bent['block.end-1.z'].max():.3g} mm"]


@pytest.mark.parametrize(
    ("bends", "told"),
    [
        ("beam: {EI y: 6 GN m2, mass: 160 t}", "the block has 150 t, of which no 160 t can bend"),
        ("com: [1 m, 0 m, 0 m]\n  beam: {EI y: 6 GN m2}", "give the beam a 'mass' below the block's"),
        (
            "beam: {EI y: 6 GN m2}\n  modes: {a: {frequency: 1 Hz, mass: 1 t, shape: {L0: [0, 0, 1]}}}",
            "either a 'beam' or",
        ),
        ("modes: {a: {frequency: 1 Hz, mass: 1 t, shape: {L9: [0, 0, 1]}}}", "the block has no lug or support 'L9'"),
        ("modes: {a: {frequency: 1 Hz, mass: 1 t, shape: {L0: [0, 0, 0]}}}", "mode 1 needs a displacement"),
        ("beam: {EI y: 6 GN m2}\nfloor: {height: 0 m}", "only rigid blocks meet floor"),
        ("inertia: [1 t m2, 1 t m2, 1 t m2]\n  beam: {EI y: 6 GN m2}", "give the beam a 'mass', that of what bends"),
    ],
)
def test_an_impossible_flexible_block_is_reported(bends: str, told: str) -> None:
    with pytest.raises(SceneError, match=told):
        hung(bends)
