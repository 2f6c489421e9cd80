"""Flexible bodies of a mechanism: the keys `beam` and `matrices`, and the kernel's description made from them.

A beam lies along the x axis of its body's frame; joints, ropes and forces are placed on it by `at: 30 m`. Matrices come
from files in the scene's folder: .csv, or an array in an .npz that has the name of the key.
"""

import re
import zlib
from io import BytesIO, StringIO
from pathlib import Path
from typing import Annotated, Literal
from zipfile import BadZipFile, ZipFile

import numpy as np
from heavylift.kernel.description import flexible as k
from heavylift.nodes.scene.keys.base import Base, keys_of
from heavylift.nodes.scene.text import units as u
from heavylift.nodes.scene.text.files import content, within
from numpy.typing import NDArray
from pydantic import Discriminator, Field, Tag, field_validator, model_validator

LARGEST = 1 << 25  # of a matrix [bytes]
# what zipfile and NumPy raise of archives that are damaged, or packed in a way that they do not know
BROKEN = (BadZipFile, MemoryError, zlib.error, EOFError, OverflowError, NotImplementedError, RuntimeError, TypeError)


class Section(Base):
    """Cross-section of a beam: area, second moments of area about y and z, torsion constant."""

    area: u.Area = 0.0
    Iy: u.SecondMoment = 0.0
    Iz: u.SecondMoment = 0.0
    J: u.SecondMoment = 0.0


class Stiffness(keys_of(k.Beam, "length", "mass_per_length", "polar", "start")):  # type: ignore[misc]
    """Section stiffness of a uniform beam: EI, EA and GJ, given directly or by E, G and `section`.

    A beam is rigid in a stiffness that is omitted."""

    E: u.Modulus = 0.0
    G: u.Modulus = 0.0
    section: Section = Section()
    modes: int = Field(default=3, ge=0, le=30)
    damping: u.Ratio = 0.0
    loads: list[u.Length] = Field(default_factory=list)

    @property
    def stiffness(self) -> tuple[float, float, float, float]:
        """EI about y [N m2], EI about z [N m2], EA [N] and GJ [N m2]."""
        s, E, G = self.section, self.E, self.G
        return self.EI_y or E * s.Iy, self.EI_z or E * s.Iz, self.EA or E * s.area, self.GJ or G * s.J


class BeamKeys(Stiffness):
    """A uniform beam with its length and mass."""

    length: u.Extent
    mass: u.Mass | None = None
    mass_per_length: u.MassPerLength | None = None
    rotary_inertia: u.RotaryInertia = 0.0  # about the beam's axis, per length
    frame: Literal["clamped", "simply supported", "free"] = "clamped"

    @model_validator(mode="after")
    def _one_mass(self) -> "BeamKeys":
        if (self.mass is None) == (self.mass_per_length is None):
            raise ValueError("a beam has either 'mass' or 'mass per length'")
        return self

    def built(self, folder: Path, root: Path) -> k.Flexible:
        """Return the kernel's description of the beam."""
        per_length = self.mass_per_length or (self.mass or 0.0) / self.length
        beam = k.Beam(self.length, per_length, *self.stiffness, self.rotary_inertia, self.elements)
        return k.Flexible(self.modes, beam, frame=self.frame, damping=self.damping, loads=tuple(self.loads))


class GirderKeys(Base):
    """A girder: the part of a body that bends, at the more detailed model levels, along the body's y axis.

    The legs are at y = 0 and `span`."""

    slides: list[str] = Field(default_factory=list)  # joints of what slides on it
    mass: u.Mass
    stiffness: u.Stiffness  # at midspan
    span: u.Extent
    height: u.Length  # of its neutral axis
    damping: u.Ratio = 0.01  # of critical, of its first mode


class Elastic(Base):
    """A body that bends, at the more detailed model levels, as a uniform beam along the x axis of its frame.

    It has equal stiffness about y and z. By default, `length` is the length of the body's box and `mass` the mass of
    the body."""

    EI: u.Rigidity
    length: u.Extent | None = None
    mass: u.Mass | None = None
    damping: u.Ratio = 0.0
    modes: int = Field(default=2, ge=1, le=30)
    frame: Literal["clamped", "simply supported"] = "clamped"


class ServoKeys(Base):
    """A prescribed drive that is a compliant servo at the more detailed model levels."""

    stiffness: u.AnyStiffness
    damping: u.AnyDamping = 0.0


class RopeMass(Base):
    """A rope that has mass at the more detailed model levels."""

    mass_per_length: u.MassPerLength


def _optional(given: object) -> str:
    """Return the kind of optional part (boom, girder, rope or drive) that the given keys describe."""
    keys = {key.replace("_", " ") for key in given} if isinstance(given, dict) else {*vars(given)}
    marks = {"EI": "boom", "span": "girder", "slides": "girder", "mass per length": "rope"}
    return next((part for key, part in marks.items() if key.replace(" ", "_") in keys or key in keys), "drive")


Optional = Annotated[
    Annotated[Elastic, Tag("boom")] | Annotated[GirderKeys, Tag("girder")] | Annotated[RopeMass, Tag("rope")]
    | Annotated[ServoKeys, Tag("drive")],
    Discriminator(_optional),
]  # fmt: skip


class Hull(Stiffness):
    """A block that bends as a uniform beam along its x axis from end to end, relative to its mean frame."""

    mass: u.Mass | None = None  # that bends with it; left out: all of the block's


class ModeKeys(Base):
    """A free-free vibration mode of a block. Lugs and supports that are not listed move with the block's frame."""

    frequency: u.Frequency
    mass: u.Mass  # at the scale of its shape
    damping: u.Ratio = 0.0
    shape: dict[str, tuple[u.Number, u.Number, u.Number]]  # of lugs, and of places `at`


class Matrices(Base):
    """Mass and stiffness matrices of a finite-element model with 3 or 6 degrees of freedom at each node.

    The rows of `nodes` are positions [m]. `held`: degrees of freedom, counted from 0, that are fixed to the body's
    frame; `shapes` (columns) are used instead of the eigenmodes."""

    nodes: str
    mass: str
    stiffness: str
    shapes: str = ""
    held: list[int] = Field(default_factory=list)
    modes: int = Field(default=3, ge=0, le=30)
    damping: u.Ratio = 0.0

    @field_validator("nodes", "mass", "stiffness", "shapes")
    @classmethod
    def _readable(cls, file: str) -> str:
        if file and Path(file).suffix not in (".csv", ".npz"):
            raise ValueError(f"'{file}' is neither a .csv nor an .npz file")
        return file

    def built(self, folder: Path, root: Path) -> k.Flexible:
        """Return the kernel's description of the flexible body; raises ValueError for an unreadable file.

        Files must be in the folder `root`."""
        nodes = tuple((float(x), float(y), float(z)) for x, y, z in self._array(folder, root, "nodes", 3))
        nodal = k.Nodal(
            nodes=nodes,
            mass=self._array(folder, root, "mass"),
            stiffness=self._array(folder, root, "stiffness"),
            held=tuple(self.held),
            modes=self._array(folder, root, "shapes") if self.shapes else (),
        )
        return k.Flexible(self.modes, nodal=nodal, damping=self.damping)

    def _array(self, folder: Path, root: Path, key: str, columns: int = 0) -> tuple[tuple[float, ...], ...]:
        file = str(getattr(self, key))
        data = self._data(folder / file, within(root, folder / file))
        try:
            if file.endswith(".npz"):
                array = _member(data, key)
            else:
                array = np.loadtxt(StringIO(data.decode()), delimiter=",", ndmin=2)
        except KeyError:
            raise ValueError(f"'{file}' has no array '{key}'") from None
        except (*BROKEN, ValueError) as error:  # without what it quotes of the file
            place = re.search(r"at row \d+, column \d+", str(error))
            raise ValueError(
                f"'{file}' cannot be read as numbers{' ' if place else ''}{place[0] if place else ''}"
            ) from None
        if array.ndim != 2 or (columns and array.shape[1] != columns):
            raise ValueError(f"'{file}' has a wrong number of rows or columns for '{key}'")
        return tuple(tuple(map(float, row)) for row in array)

    def _data(self, file: Path, path: Path) -> bytes:
        try:
            return content(path, LARGEST)
        except FileNotFoundError:
            raise ValueError(f"there is no file '{file}'") from None
        except OSError as error:
            raise ValueError(f"'{file}' cannot be read: {error.strerror}") from None


def _member(data: bytes, key: str) -> NDArray[np.float64]:
    """Return an array of an .npz file; raises KeyError, ValueError or an error in BROKEN if it is missing, not numeric
    or too large."""
    with ZipFile(BytesIO(data)) as archive, archive.open(f"{key}.npy") as member:
        if archive.getinfo(f"{key}.npy").file_size > LARGEST:
            raise ValueError
        return np.array(np.load(BytesIO(member.read(LARGEST)), allow_pickle=False), float)
