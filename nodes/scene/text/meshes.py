"""Shapes of blocks from files in the scene's folder: STL or glTF (.stl, .glb, .gltf), closed surfaces of triangles.

    block: {shape: hull.stl, mass: 320 t, ...}      or {shape: {file: hull.stl, unit: mm, density: 400 kg/m3}, ...}

The integrals over the polyhedron are exact, as sums over the tetrahedra below its triangles (Mirtich, Journal of
Graphics Tools 1 (1996) 31-50). A centre of mass and moments given with the block take precedence. The block's origin is
the centre of the shape's bounding box; for drawings and clearances the shape is represented by slices that contain it.
"""

import io
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import fsum, isfinite
from typing import Any
from warnings import catch_warnings

from heavylift.kernel.errors import SceneError, extra

from .faults import raise_faults
from .files import content, within
from .source import Data, Path, SourceText
from .units import DENSITY, LENGTH, MASS

LARGEST = 1 << 25  # of a file [bytes]
SLICES = 12
SMALL, LARGE = 0.05, 1000.0  # [m] between which the longest edge of a block lies
NOISE = 1e-9  # of the largest moment: products that are rounding
THIN = 1e-3  # [m] of a slice
SAME = 1e-3  # relative, of a size that is given besides
FLAT = 1e-12  # of the cube of its longest edge: a volume that is rounding
COMPRESSED = (b"KHR_draco_mesh_compression", b"EXT_meshopt_compression")
YUP = ("glb", "gltf")  # formats whose y points up and whose unit is the metre

Vector = tuple[float, float, float]
Triangle = tuple[Vector, Vector, Vector]


@dataclass(frozen=True)
class MeshProperties:
    """Volume [m3], centroid [m] and second moments [m5] of a shape.

    Ixx, Iyy, Izz, Ixy, Ixz, Iyz are about the centroid for density 1."""

    volume: float
    middle: Vector
    moments: tuple[float, ...]


def shaped(source: SourceText) -> None:
    """Compute size and mass properties of each block that has a `shape`; raises SceneError if that is impossible."""
    several = source.data.get("blocks")
    for base in (("block",), *(("blocks", name) for name in (several if isinstance(several, dict) else ()))):
        block = source.at(base)
        if isinstance(block, dict) and "shape" in block:
            try:
                _put(source, base, block)
            except (SceneError, ValueError) as error:
                source.fault((*base, "shape"), str(error))
                raise_faults(source, source.faults)


def _put(source: SourceText, base: Path, block: dict[str, Data]) -> None:
    given = block["shape"]
    shape: dict[str, Data] = dict(given) if isinstance(given, dict) else {"file": given}
    file, unit = shape.get("file"), str(shape.get("unit", "m"))
    if not isinstance(file, str) or unit not in LENGTH.units:
        raise SceneError("write a file, such as 'hull.stl', or '{file: hull.stl, unit: mm}'")
    triangles = _scaled(_read(source, file), float(LENGTH.units[unit]))
    low, high = _bounds(triangles)
    size = [b - a for a, b in zip(low, high, strict=True)]
    _check_size(file, size, block.get("size"))
    found, middle = solid(triangles), [(a + b) / 2.0 for a, b in zip(low, high, strict=True)]
    density = shape.get("density")
    if (density is None) == ("mass" not in block):
        raise SceneError("a block with a shape has either a 'mass' or, with its shape, a 'density'")
    mass = MASS.read(block["mass"]) if density is None else DENSITY.read(density) * found.volume
    heaviest = max(found.moments[:3])
    moments = [x if abs(x) > NOISE * heaviest else 0.0 for x in found.moments]
    shape["file"] = file
    shape["slices"] = [[_lengths(at), _lengths(edges)] for at, edges in slices(_moved(triangles, middle), SLICES)]
    made: dict[str, Data] = {
        "mass": f"{mass!r} kg",
        "size": _lengths(size),
        "com": _lengths([a - b for a, b in zip(found.middle, middle, strict=True)]),
        "inertia": [f"{mass / found.volume * x!r} kg m2" for x in moments[: 6 if any(moments[3:]) else 3]],
    }
    mark = source.mark((*base, "shape"))
    for key, value in made.items():
        if key not in block:
            block[key] = value
            source.keys[(*base, key)] = source.values[(*base, key)] = mark
    block["shape"] = shape


def _lengths(values: Sequence[float]) -> list[Data]:
    return [f"{x!r} m" for x in values]


def _check_size(file: str, size: Sequence[float], given: Data) -> None:
    """Raise SceneError if the size of a shape does not fit that of the block, for example in another unit."""
    if isinstance(given, list):
        wanted = [LENGTH.read(x) for x in given]
        if any(abs(a - b) > SAME * b for a, b in zip(size, wanted, strict=True)):
            shown = [" x ".join(f"{x:.4g}" for x in each) for each in (size, wanted)]
            raise SceneError(
                f"'{file}' measures {shown[0]} m, but the block {shown[1]} m: remove 'size', or give the unit "
                "of the file"
            )
    elif not SMALL <= max(size) <= LARGE:
        raise SceneError(
            f"'{file}' is {max(size):.4g} m long; give its unit, such as 'shape: {{file: {file}, unit: mm}}'"
        )


def _read(source: SourceText, file: str) -> list[Triangle]:
    """Return the triangles of a file, oriented outwards, with z upwards; raises SceneError unless they close a
    surface."""
    kind = file.rpartition(".")[2].lower()
    if kind not in ("stl", *YUP):
        raise SceneError(f"'{file}' is not a .stl, .glb or .gltf file")
    trimesh = extra("trimesh", SceneError("a shape needs trimesh: pip install 'heavylift[shapes]'"))
    try:
        data = content(within(source.root, source.root / file), LARGEST)
    except OSError as error:
        raise SceneError(f"the shape '{file}' cannot be read: {error.strerror}") from None
    try:
        with catch_warnings(action="ignore"):  # in words of NumPy
            mesh: Any = trimesh.load(io.BytesIO(data), file_type=kind, force="mesh")
            faces = mesh.triangles.tolist()
            closed = bool(mesh.is_watertight and mesh.is_winding_consistent)
    except Exception:  # whatever a broken file makes of the library
        faces, closed = [], False
    if not faces:
        raise SceneError(f"the shape '{file}' cannot be read: {_why(kind, data)}")
    if not all(isfinite(x) for each in faces for p in each for x in p):
        raise SceneError(
            f"the shape '{file}' has coordinates that are not finite numbers: correct it in the program that drew it"
        )
    if not closed:
        raise SceneError(f"the surface in '{file}' is not closed: correct it in the program that drew it")
    turned: list[Triangle] = [(_up(a, kind), _up(b, kind), _up(c, kind)) for a, b, c in faces]
    volume = solid(turned).volume
    size = max(b - a for a, b in zip(*_bounds(turned), strict=True))
    if not abs(volume) > FLAT * size * size * size:
        raise SceneError(f"the surface in '{file}' has no inside: draw it as a solid with walls, or give 'size'")
    return turned if volume > 0.0 else [(a, c, b) for a, b, c in turned]


def _why(kind: str, data: bytes) -> str:
    """Return the reason why a file has no readable triangles, with the remedy."""
    if not data:
        return "it is empty; write it anew from the program that it was drawn in"
    if kind in YUP and any(word in data for word in COMPRESSED):
        return "its surface is compressed; write it without compression"
    if kind == "gltf" and (
        other := next((x for x in re.findall(rb'"uri"\s*:\s*"([^"]*)"', data) if x[:5] != b"data:"), b"")
    ):
        return f"it needs another file, '{other.decode(errors='replace')}'; write all into one .glb file"
    return f"it is broken, cut off, or no {kind} file; write it anew from the program that it was drawn in"


def _up(p: Vector, kind: str) -> Vector:
    """Return a position converted to z upwards from the axes of the file format `kind`."""
    x, y, z = p
    return (x, -z, y) if kind in YUP else (x, y, z)


def _scaled(triangles: list[Triangle], factor: float) -> list[Triangle]:
    return [tuple(tuple(factor * x for x in p) for p in each) for each in triangles]  # type: ignore[misc]


def _moved(triangles: list[Triangle], by: Sequence[float]) -> list[Triangle]:
    return [tuple(tuple(x - b for x, b in zip(p, by, strict=True)) for p in each) for each in triangles]  # type: ignore[misc]


def _bounds(triangles: Sequence[Sequence[Vector]]) -> tuple[list[float], list[float]]:
    columns = list(zip(*(p for each in triangles for p in each), strict=True))
    return [min(x) for x in columns], [max(x) for x in columns]


def solid(triangles: Sequence[Triangle]) -> MeshProperties:
    """Return the mass properties of the volume inside a closed surface, for density 1."""
    signed = [(_determinant(a, b, c), a, b, c) for a, b, c in triangles]
    volume = fsum(d for d, *_ in signed) / 6.0
    sums = [[p[i] + q[i] + r[i] for i in range(3)] for _, p, q, r in signed]
    middle = [
        fsum(d * s[i] for (d, *_), s in zip(signed, sums, strict=True)) / 24.0 / (volume or 1.0) for i in range(3)
    ]

    def second(i: int, j: int) -> float:
        terms = (
            d * (s[i] * s[j] + p[i] * p[j] + q[i] * q[j] + r[i] * r[j])
            for (d, p, q, r), s in zip(signed, sums, strict=True)
        )
        return fsum(terms) / 120.0 - volume * middle[i] * middle[j]

    xx, yy, zz, xy, xz, yz = (second(i, j) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)))
    return MeshProperties(volume, (middle[0], middle[1], middle[2]), (yy + zz, xx + zz, xx + yy, -xy, -xz, -yz))


def _determinant(a: Vector, b: Vector, c: Vector) -> float:
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])


def slices(triangles: Sequence[Triangle], n: int) -> Iterator[tuple[list[float], list[float]]]:
    """Yield n boxes, as (centre, edges) [m], that together enclose a surface, in slices along its longest edge."""
    low, high = _bounds(triangles)
    along = max(range(3), key=lambda i: high[i] - low[i])
    step = (high[along] - low[along]) / n
    for k in range(n):
        ends = low[along] + k * step, low[along] + (k + 1) * step
        inside = [p for each in triangles for p in _cut(each, along, *ends)]
        if inside:
            least, most = _bounds([inside])
            least[along], most[along] = ends
            yield (
                [(a + b) / 2.0 for a, b in zip(least, most, strict=True)],
                [max(b - a, THIN) for a, b in zip(least, most, strict=True)],
            )


def _cut(triangle: Triangle, axis: int, low: float, high: float) -> Iterator[Vector]:
    """Yield the corners of a triangle that lie between two planes, and its intersections with the planes."""
    for a, b in zip(triangle, (*triangle[1:], triangle[0]), strict=True):
        if low <= a[axis] <= high:
            yield a
        for plane in (low, high):
            if (a[axis] - plane) * (b[axis] - plane) < 0.0:
                part = (plane - a[axis]) / (b[axis] - a[axis])
                x, y, z = (p + part * (q - p) for p, q in zip(a, b, strict=True))
                yield x, y, z
