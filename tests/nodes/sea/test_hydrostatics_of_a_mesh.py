"""Hydrostatics of a mesh against closed forms: a box, a shifted box, a wedge and a hemisphere; a level keel."""

from __future__ import annotations

import numpy as np
import pytest
from heavylift.kernel import SceneError
from heavylift.kernel.description import Bushing
from heavylift.nodes.scene import parse
from heavylift.nodes.scenes import vessels_folder
from heavylift.nodes.sea import hydrostatics_of, read_hydrodynamics

WEIGHT = 1025.0 * 9.81
ROUNDING = 1e-12
PANELS = 2e-3  # relative: flat panels inscribed in a sphere, 48 along a meridian


def box(length: float, beam: float, draught: float, x: float = 0.0, y: float = 0.0, lid: bool = False) -> np.ndarray:
    """Four sides and a bottom of quadrilaterals, normals outwards."""
    a, b = 0.5 * length, 0.5 * beam
    corners = [(-a, -b), (a, -b), (a, b), (-a, b)]
    top = [(x + p, y + q, 0.0) for p, q in corners]
    low = [(p, q, -draught) for p, q, _ in top]
    sides = [[low[i], low[(i + 1) % 4], top[(i + 1) % 4], top[i]] for i in range(4)]
    return np.array([*sides, low[::-1], *([top] if lid else [])])


def hemisphere(radius: float, n: int = 48) -> np.ndarray:
    """Quadrilaterals between meridians and parallels; triangles at the pole repeat a corner."""
    down, around = np.linspace(0.0, 0.5 * np.pi, n + 1), np.linspace(0.0, 2.0 * np.pi, 4 * n + 1)

    def at(i: int, j: int) -> list[float]:
        ring = radius * np.cos(down[i])
        return [ring * np.cos(around[j]), ring * np.sin(around[j]), -radius * np.sin(down[i])]

    return np.array(
        [[at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)] for i in range(n) for j in range(4 * n)]
    )  # fmt: skip


@pytest.mark.parametrize("lid", [False, True])
@pytest.mark.parametrize("inside_out", [False, True])
def test_hydrostatics_of_a_box_away_from_the_origin_agree_with_the_closed_form(lid: bool, inside_out: bool) -> None:
    L, B, T, x, y = 110.0, 32.0, 4.0, 3.0, -2.0
    panels = box(L, B, T, x, y, lid)
    of = hydrostatics_of(panels[:, ::-1] if inside_out else panels)
    area = L * B
    assert of.volume == pytest.approx(area * T, rel=ROUNDING)
    assert of.buoyancy == pytest.approx([x, y, -0.5 * T], rel=ROUNDING)
    want = np.zeros((6, 6))
    want[2, 2] = area
    want[2, 3] = want[3, 2] = area * y
    want[2, 4] = want[4, 2] = -area * x
    want[3, 3] = area * (B * B / 12.0 + y * y) - 0.5 * area * T * T
    want[4, 4] = area * (L * L / 12.0 + x * x) - 0.5 * area * T * T
    want[3, 4] = want[4, 3] = -area * x * y
    assert np.abs(of.stiffness(WEIGHT) - WEIGHT * want).max() < ROUNDING * WEIGHT * want.max()


def test_a_wedge_has_the_volume_and_metacentre_of_its_triangle() -> None:
    """Beam B, draught T, length L: volume L B T / 2, centre of buoyancy at a third of T, BM = B^2 / 6 T."""
    L, B, T = 60.0, 18.0, 6.0
    keel = [(-0.5 * L, 0.0, -T), (0.5 * L, 0.0, -T)]
    port, starboard = ([(s * 0.5 * L, y, 0.0) for s in (-1, 1)] for y in (0.5 * B, -0.5 * B))
    sides = [[keel[1], keel[0], port[0], port[1]], [keel[0], keel[1], starboard[1], starboard[0]]]
    ends = [
        [keel[i], port[i], starboard[i], keel[i]] if i else [keel[i], starboard[i], port[i], keel[i]] for i in (0, 1)
    ]
    of = hydrostatics_of(np.array(sides + [x[::-1] for x in ends]))
    assert of.volume == pytest.approx(0.5 * L * B * T, rel=ROUNDING)
    assert of.buoyancy == pytest.approx([0.0, 0.0, -T / 3.0], abs=ROUNDING * T)
    metacentre = of.stiffness(1.0)[3, 3] / of.volume
    assert metacentre == pytest.approx(B * B / (6.0 * T) - T / 3.0, rel=1e-9)


def test_hydrostatics_of_a_hemisphere_tend_to_its_closed_form() -> None:
    """Volume 2/3 pi R^3, buoyancy at 3/8 R; it turns about its centre without stiffness."""
    R = 5.0
    of = hydrostatics_of(hemisphere(R))
    assert of.volume == pytest.approx(2.0 / 3.0 * np.pi * R**3, rel=PANELS)
    assert of.buoyancy == pytest.approx([0.0, 0.0, -0.375 * R], abs=PANELS * R)
    assert of.waterplane == pytest.approx(np.pi * R * R, rel=PANELS)
    K = of.stiffness(WEIGHT)
    assert np.abs(K[3:5, 3:5]).max() < PANELS * WEIGHT * of.volume * R
    coarse = hydrostatics_of(hemisphere(R, 12))
    ratio = (2.0 / 3.0 * np.pi * R**3 - coarse.volume) / (2.0 / 3.0 * np.pi * R**3 - of.volume)
    assert ratio == pytest.approx(16.0, rel=0.02), "the error goes with the square of the panels"


def test_a_flat_mesh_is_refused_as_a_hull() -> None:
    with pytest.raises(SceneError, match="encloses no volume below z = 0"):
        hydrostatics_of(np.array([[[0.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, -2.0]]]))


@pytest.mark.parametrize(("name", "size"), [("barge-110", (110.0, 32.0, 4.0)), ("barge-75", (75.0, 24.0, 2.5))])
def test_bundled_hulls_have_the_hydrostatics_of_their_boxes(name: str, size: tuple[float, float, float]) -> None:
    path = vessels_folder() / f"{name}.json"
    of, mesh = read_hydrodynamics(path.read_bytes(), path.name), hydrostatics_of(box(*size))
    assert (of.volume, of.waterplane) == pytest.approx((mesh.volume, mesh.waterplane), rel=1e-6)
    assert of.buoyancy == pytest.approx(mesh.buoyancy, abs=1e-6)
    K = mesh.stiffness(1.0)
    assert of.metacentres == pytest.approx([K[i, i] / mesh.volume for i in (3, 4)], rel=1e-6)


SCENE = """
heavylift: 1
name: keel
end: 20 s
vessels:
  barge:
    mass: 14432 t
    size: [110 m, 32 m, 8 m]
    draught: 4 m
    com: [%s m, %s m, 2 m]
    motion: forces
    floating: {hydrodynamics: %s, mooring: {surge: 400 kN/m}}
actions: [{wait: 1 s}]
"""


def test_a_vessel_whose_mass_is_not_above_its_centre_of_buoyancy_is_refused() -> None:
    """The metacentric heights are 17.3 m across and 248 m along."""
    with pytest.raises(SceneError, match=r"0 m ahead and 1 m to port of its .* would not float level"):
        parse(SCENE % (0, 1, "barge-110"))
    assert parse(SCENE % (1, 0.2, "barge-110")).plan.machines


def test_waterplane_moments_couple_heave_with_roll_and_pitch(tmp_path) -> None:
    text = (vessels_folder() / "barge-110.json").read_text()
    (tmp_path / "hull.json").write_text(text.replace('"buoyancy"', '"moments": [7040.0, -3520.0, 500.0], "buoyancy"'))
    (tmp_path / "keel.yaml").write_text(SCENE % (0, 0, "hull.json"))
    from heavylift.nodes.scene import load

    forces = load(tmp_path / "keel.yaml").plan.machines[0].system.forces
    K = np.array(next(f.K for f in forces if isinstance(f, Bushing)))
    water = 1025.0 * 9.80665
    assert K[2, 2:5] == pytest.approx([water * 3520.0, water * -3520.0, water * -7040.0])
    assert K[3, 4] == pytest.approx(water * -500.0)
    assert (K == K.T).all()
