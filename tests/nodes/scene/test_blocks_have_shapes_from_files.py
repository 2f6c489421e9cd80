"""`shape:` of a block: mass and centre of mass of a closed mesh, its drawing, and refused files."""

from __future__ import annotations

import json
import re
import sys
from itertools import pairwise
from math import pi
from pathlib import Path
from random import Random

import numpy as np
import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.models import system
from heavylift.nodes.plan import Shapes, around
from heavylift.nodes.scene import LoadedScene, load
from heavylift.nodes.scene.text import slices, solid
from lifting import cargo

trimesh = pytest.importorskip("trimesh")

SCENE = """
heavylift: 1
name: shaped
end: 1 s
block:
  shape: %s
  at: [0 m, 0 m, 2 m]
  %s
  lugs: {N1: [0 m, 0 m, 1 m]}
  supports: {height: 0.5 m, at: [[-2 m, -1 m], [2 m, -1 m], [-2 m, 1 m], [2 m, 1 m]]}
floor: {}
"""


def scene(
    folder: Path, mesh: trimesh.Trimesh, file: str = "hull.stl", shape: str = "", more: str = "mass: 60 t"
) -> LoadedScene:
    """A scene beside the file of a mesh."""
    mesh.export(folder / file)
    path = folder / "shaped.yaml"
    path.write_text(SCENE % (shape or file, more))
    return load(path)


def hull() -> trimesh.Trimesh:
    """A prism with a bow that is no mirror image of anything."""
    points = np.array([(-4, -2, 0), (3, -2, 0), (5, 1, 0), (-4, 2, 0)], float)
    return trimesh.convex.convex_hull(np.vstack([points, points * [0.8, 0.7, 1.0] + [0.3, 0.0, 3.0]]))


def test_moments_of_inertia_of_a_box_and_a_tetrahedron_mesh_are_those_of_textbooks() -> None:
    """12 I = m (b2 + c2) of a box; of a corner of it I = 3/80 m (b2 + c2), its middle at a quarter of each edge."""
    found = solid(trimesh.creation.box((6.0, 4.0, 2.0)).triangles.tolist())
    assert found.volume == pytest.approx(48.0, rel=1e-14)
    assert found.moments == pytest.approx((4.0 * 20.0, 4.0 * 40.0, 4.0 * 52.0, 0.0, 0.0, 0.0), abs=1e-12)
    o, a, b, c = (0.0, 0.0, 0.0), (6.0, 0.0, 0.0), (0.0, 4.0, 0.0), (0.0, 0.0, 2.0)
    found = solid([(o, b, a), (o, a, c), (o, c, b), (a, b, c)])
    assert found.volume == pytest.approx(8.0, rel=1e-14)
    assert found.middle == pytest.approx((1.5, 1.0, 0.5), rel=1e-14)
    assert found.moments[:3] == pytest.approx([0.3 * x for x in (20.0, 40.0, 52.0)], rel=1e-13)
    assert found.moments[3:] == pytest.approx([8.0 / 80.0 * x for x in (24.0, 12.0, 8.0)], rel=1e-13)


def test_the_moment_of_inertia_of_finer_ball_meshes_approaches_two_fifths_of_m_r_squared() -> None:
    """Errors of volume and moment fall by four with each division of the triangles, as those of inscribed planes do."""
    errors = []
    for n in (2, 3, 4):
        found = solid(trimesh.creation.icosphere(n, radius=2.0).triangles.tolist())
        errors.append(1.0 - found.moments[0] / (0.4 * (4.0 / 3.0 * pi * 8.0) * 4.0))
    assert errors[-1] < 0.01
    assert [a / b for a, b in pairwise(errors)] == pytest.approx([4.0, 4.0], rel=0.05)


def test_mass_properties_of_an_irregular_hull_agree_with_another_library(tmp_path: Path) -> None:
    """Centre of mass and all six moments against trimesh, of a stated mass and of a density, and in millimetres."""
    mesh = hull()
    box = (mesh.bounds[0] + mesh.bounds[1]) / 2.0
    whole = scene(tmp_path, mesh)
    block = cargo(whole.plan)
    assert block.size == pytest.approx(mesh.extents, rel=1e-6)
    assert block.com == pytest.approx(mesh.center_mass - box, rel=1e-5)
    body = next(b for b in system(whole.plan).bodies if b.name == "block")
    assert np.array(body.inertia) == pytest.approx(60e3 / mesh.volume * mesh.moment_inertia, rel=1e-5, abs=1.0)
    mesh.apply_scale(1000.0)
    small = scene(tmp_path, mesh, "mm.stl", "{file: mm.stl, unit: mm, density: 800 kg/m3}", "").plan
    assert cargo(small).mass == pytest.approx(800.0 * mesh.volume * 1e-9, rel=1e-5)
    assert cargo(small).size == pytest.approx(block.size, rel=1e-5)


def test_gltf_files_are_read_with_y_as_the_vertical_axis(tmp_path: Path) -> None:
    """A box 6 m long, 3 m high in the file's y: it is 3 m high in the scene's z."""
    box = trimesh.creation.box((6.0, 3.0, 2.0))
    block = cargo(scene(tmp_path, box, "box.glb").plan)
    assert block.size == pytest.approx((6.0, 2.0, 3.0))


def test_a_mesh_is_drawn_as_twelve_boxes_that_contain_its_surface(tmp_path: Path) -> None:
    """Twelve along the longest edge, of which each point of the surface lies in one; together less than the box."""
    mesh = hull()
    boxes = list(slices(mesh.triangles.tolist(), 12))
    points = trimesh.sample.sample_surface(mesh, 500, seed=1)[0]
    inside = [np.all(np.abs(points - at) <= 0.5 * np.array(edges) + 1e-9, axis=1) for at, edges in boxes]
    assert len(boxes) == 12
    assert np.any(inside, axis=0).all()
    assert mesh.volume < sum(np.prod(edges) for _, edges in boxes) < np.prod(mesh.extents)
    drawn = [x for x in Shapes(scene(tmp_path, mesh).plan).solids if x.kind == "block"]
    assert len(drawn) == 12


@pytest.mark.parametrize(
    ("shape", "more", "told"),
    [
        ("open.stl", "mass: 60 t", "the surface in 'open.stl' is not closed: correct it in the program that drew it"),
        ("no.stl", "mass: 60 t", "the shape 'no.stl' cannot be read: No such file or directory"),
        ("hull.step", "mass: 60 t", "'hull.step' is not a .stl, .glb or .gltf file"),
        ("large.stl", "mass: 60 t", "'large.stl' is 9000 m long; give its unit, such as"),
        ("hull.stl", "", "has either a 'mass' or, with its shape, a 'density'"),
        (
            "hull.stl",
            "{mass: 60 t, size: [9 m, 4 m, 4 m]}",
            "'hull.stl' measures 9 x 4 x 3 m, but the block 9",
        ),
        ("noise.stl", "mass: 60 t", "'noise.stl'"),
        ("../hull.stl", "mass: 60 t", "is outside of the scene's folder"),
    ],
)
def test_an_invalid_mesh_is_refused_in_one_sentence(tmp_path: Path, shape: str, more: str, told: str) -> None:
    """With the place in the scene."""
    mesh = hull()
    trimesh.Trimesh(mesh.vertices, mesh.faces[1:]).export(tmp_path / "open.stl")
    (tmp_path / "noise.stl").write_bytes(b"solid nothing")
    big = mesh.copy()
    big.apply_scale(1000.0)
    big.export(tmp_path / "large.stl")
    more = more.strip("{}").replace(", size", "\n  size")
    with pytest.raises(SceneError, match=r"shaped\.yaml:6:\d+") as error:
        scene(tmp_path, mesh, shape=shape, more=more)
    assert told in str(error.value)


def test_a_missing_library_for_meshes_is_reported_with_the_extra_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One sentence."""
    mesh = hull()
    mesh.export(tmp_path / "hull.stl")
    monkeypatch.setitem(sys.modules, "trimesh", None)
    (tmp_path / "shaped.yaml").write_text(SCENE % ("hull.stl", "mass: 60 t"))
    with pytest.raises(SceneError, match=r"a shape needs trimesh: pip install 'heavylift\[shapes\]'"):
        load(tmp_path / "shaped.yaml")


def test_a_mesh_can_give_the_shape_of_one_of_several_blocks(tmp_path: Path) -> None:
    """Its slices are drawn, and the box around them is what gaps are measured from."""
    mesh = hull()
    mesh.export(tmp_path / "hull.stl")
    text = SCENE.replace("block:", "blocks:\n ship:").replace("\n  ", "\n    ") % ("hull.stl", "mass: 60 t")
    (tmp_path / "shaped.yaml").write_text(text)
    machine = next(m for m in load(tmp_path / "shaped.yaml").plan.machines if m.name == "ship")
    assert len(machine.shapes) == 12
    centre, size = around([(x.centre, x.size) for x in machine.shapes])
    assert centre == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    assert size == pytest.approx(mesh.extents, rel=1e-6)


def gltf(mesh: trimesh.Trimesh, **changes: object) -> bytes:
    """A .gltf file with its buffer beside it, and these keys."""
    files = mesh.scene().export(file_type="gltf")
    return json.dumps(json.loads(files["model.gltf"]) | changes).encode()


def text_stl(*corners: str) -> bytes:
    """A surface of one triangle, as text."""
    vertices = "".join(f"vertex {corner}\n" for corner in corners)
    return f"solid x\nfacet normal 0 0 1\nouter loop\n{vertices}endloop\nendfacet\nendsolid x\n".encode()


BOX = trimesh.creation.box((6.0, 4.0, 2.0))
FLAT = trimesh.Trimesh(BOX.vertices * [1.0, 1.0, 0.0], BOX.faces, process=False)
BROKEN = {
    "empty.stl": (b"", "is empty; write it anew"),
    "empty.glb": (b"", "is empty; write it anew"),
    "page.stl": (b"<!DOCTYPE html><html>404</html>", "is broken, cut off, or no stl file; write it anew"),
    "page.gltf": (b"<!DOCTYPE html>", "is broken, cut off, or no gltf file; write it anew"),
    "beside.gltf": (gltf(BOX), "needs another file, 'gltf_buffer_0.bin'; write all into one .glb file"),
    "draco.gltf": (gltf(BOX, extensionsRequired=["KHR_draco_mesh_compression"]), "is compressed; write it without"),
    "nothing.glb": (b"glTF\x02\0\0\0\x0c\0\0\0", "is broken, cut off, or no glb file; write it anew"),
    "nan.stl": (text_stl("0 0 0", "1 0 0", "0 nan 0"), "not finite numbers|is broken"),
    "flat.stl": (FLAT.export(file_type="stl"), "has no inside: draw it as a solid|is not closed|is broken"),
}


@pytest.mark.parametrize("file", BROKEN)
def test_a_broken_mesh_file_ends_with_a_one_sentence_error(tmp_path: Path, file: str) -> None:
    data, message = BROKEN[file]
    (tmp_path / file).write_bytes(data)
    (tmp_path / "shaped.yaml").write_text(SCENE % (file, "mass: 60 t"))
    with pytest.raises(SceneError, match=rf"shaped\.yaml:6:\d+: error: .*'{file}'.*({message})"):
        load(tmp_path / "shaped.yaml")


@pytest.mark.parametrize("kind", ["stl", "glb", "gltf"])
def test_a_corrupted_mesh_file_is_read_or_refused_in_one_sentence(tmp_path: Path, kind: str) -> None:
    """Cut, or with bytes of others: whatever the library raises, its words are not shown."""
    whole = gltf(BOX) if kind == "gltf" else BOX.export(file_type=kind)
    random = Random(kind)
    for _ in range(40):
        data = bytearray(whole[: random.randrange(len(whole))] if random.random() < 0.5 else whole)
        for _ in range(random.randrange(4) if data else 0):
            data[random.randrange(len(data))] = random.randrange(256)
        (tmp_path / f"hull.{kind}").write_bytes(data)
        (tmp_path / "shaped.yaml").write_text(SCENE % (f"hull.{kind}", "mass: 60 t"))
        message = ""
        try:
            load(tmp_path / "shaped.yaml")
        except SceneError as error:
            message = str(error)
        assert re.search(
            "^$|empty|needs another file|broken|finite|not closed|no inside|inside of|long; give|supports", message
        ), message
