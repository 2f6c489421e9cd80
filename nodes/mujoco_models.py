"""Conversion of MuJoCo models to mechanical systems: any MJCF or URDF that MuJoCo loads, by `heavylift.from_mujoco`.

Features that have an equivalent are converted exactly: bodies, joints, springs, dampers, actuators, tendons through
sites. Limits get the stiffness that MuJoCo gives them for the inertia at the start. Each other feature is listed in a
sentence.
"""

from copy import copy
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from heavylift.kernel.description import forces
from heavylift.kernel.description.mechanics import (
    WORLD,
    Body,
    Joint,
    JointKind,
    JointSpring,
    Line,
    Point,
    Rope,
    Stop,
    System,
)
from heavylift.kernel.errors import SceneError, error_text, extra

from .mujoco_shapes import Box, boxes_of
from .mujoco_tendons import WrappedTendons, row_of

LARGEST = 16_000_000  # bytes of a file
FREE, BALL, SLIDE, HINGE = range(4)
KINDS: dict[int, JointKind] = {FREE: "free", BALL: "spherical", SLIDE: "prismatic", HINGE: "revolute"}
ON_JOINT, ON_SITE = (0, 1), 4  # transmissions of actuators
GROUPS = 30  # the largest group of actuators that can be disabled
SITE, PULLEY = 3, 2  # of a tendon's path
UPRIGHT = 1e-9  # part of gravity that may be horizontal
SWITCHED = {
    "GRAVITY": ("body_gravcomp",),
    "SPRING": ("jnt_stiffness", "jnt_stiffnesspoly", "tendon_stiffness", "tendon_stiffnesspoly"),
    "DAMPER": ("dof_damping", "dof_dampingpoly", "tendon_damping", "tendon_dampingpoly"),
    "LIMIT": ("jnt_limited", "tendon_limited"),
    "FRICTIONLOSS": ("dof_frictionloss", "tendon_frictionloss"),
}  # fields of the model that a flag switches off
UNLIKE = (
    ("joint", "dof_armature", "armature"),
    ("joint", "dof_frictionloss", "dry friction"),
    ("joint", "dof_dampingpoly", "dampers that are not linear"),
    ("joint", "jnt_stiffnesspoly", "springs that are not linear"),
    ("joint", "jnt_springyield", "springs that yield"),
    ("joint", "jnt_margin", "margins of limits"),
    ("joint", "jnt_actfrclimited", "limits of the forces of actuators"),
    ("joint", "jnt_actgravcomp", "actuators that compensate gravity"),
    ("tendon", "tendon_armature", "armature"),
    ("tendon", "tendon_dampingpoly", "dampers that are not linear"),
    ("tendon", "tendon_stiffnesspoly", "springs that are not linear"),
    ("tendon", "tendon_springyield", "springs that yield"),
    ("tendon", "tendon_actfrclimited", "limits of the forces of actuators"),
    ("actuator", "actuator_armature", "armature"),
    ("actuator", "actuator_damping", "damping"),
    ("actuator", "actuator_dampingpoly", "damping"),
    ("actuator", "actuator_delay", "delay"),
    ("body", "body_gravcomp", "compensation of gravity"),
)  # owner and name of a field that has no equal if it is not 0; older versions of MuJoCo lack some


class FromMujoco(NamedTuple):
    """Result of an import from MuJoCo: the system, the points of the MJCF sites, and the features not converted."""

    system: System
    sites: dict[str, Point]
    missing: list[str]


class ImportedModel(NamedTuple):
    """Result of an import from MuJoCo, with boxes that enclose the geoms of each body (centre and edges [m])."""

    found: FromMujoco
    boxes: dict[str, list[Box]]


def from_mujoco(model: str | Path | Any) -> FromMujoco:
    """Return the mechanical system of an MJCF or URDF file, or of an MjModel; raises SceneError if it cannot be read.

    The result also has the points of the sites and a sentence for each feature that was not converted. Coordinates are
    zero in the pose `qpos0`."""
    return import_model(model).found


def import_model(path: str | Path | Any) -> ImportedModel:
    """Import an MJCF or URDF file as `from_mujoco` does, with boxes for drawings and clearances."""
    library = extra("mujoco", SceneError("models of MuJoCo need its package; install heavylift[mujoco]"))
    importer = _Importer(library, copy(path) if isinstance(path, library.MjModel) else _read(library, Path(path)))
    boxes = boxes_of(importer.m, importer.body, importer.missing, importer.matrix)
    return ImportedModel(importer.found(), boxes)


def _read(library: Any, file: Path) -> Any:
    try:
        size = file.stat().st_size
        if size > LARGEST:
            raise SceneError(f"{file}: {size / 1e6:.0f} MB; a model has at most {LARGEST / 1e6:.0f} MB")
        return library.MjModel.from_xml_path(str(file))
    except (OSError, ValueError, library.FatalError) as error:
        raise SceneError(f"{file}: {error_text(error)}") from None


class _Importer:
    """Converter of one MuJoCo model."""

    def __init__(self, library: Any, model: Any) -> None:
        self.library, self.m = library, model
        self.missing: list[str] = []
        self.bodies: list[Body] = []
        self.joints: list[Joint] = []
        self.body = [WORLD, *(self._name("body", i) for i in range(1, model.nbody))]
        self.joint = [self._name("joint", i) for i in range(model.njnt)]
        for flag in filter(self._off, SWITCHED):
            for field in SWITCHED[flag]:
                getattr(model, field, np.zeros(1))[:] = 0
        g = -model.opt.gravity * (not self._off("GRAVITY"))
        self.gravity = float(np.linalg.norm(g))
        if max(abs(g[0]), abs(g[1])) > UPRIGHT * (1.0 + abs(g[2])) or g[2] < 0.0:
            self._turn(g / self.gravity)

    def _off(self, flag: str) -> bool:
        """Return whether a flag of the model switches a feature off."""
        bits, constraint = self.library.mjtDisableBit, flag in ("LIMIT", "FRICTIONLOSS", "EQUALITY", "CONTACT")
        off = int(getattr(bits, f"mjDSBL_{flag}")) | constraint * int(bits.mjDSBL_CONSTRAINT)
        return bool(self.m.opt.disableflags & off)

    def _turn(self, up: np.ndarray) -> None:
        """Put the model on a body that is turned so that gravity acts along -z."""
        while self.body[0] in (WORLD, *self.body[1:]):
            self.body[0] = f"turned-{self.body[0]}"
        x = np.cross((0.0, 1.0, 0.0) if abs(up[1]) < 0.7 else (1.0, 0.0, 0.0), up)
        x /= np.linalg.norm(x)
        self.bodies.append(Body(self.body[0], 0.0))
        R = _rows(np.array((x, np.cross(up, x), up)))
        self.joints.append(Joint(f"{self.body[0]}-fixed", "fixed", WORLD, self.body[0], R_PJ=R))

    def found(self) -> FromMujoco:
        m = self.m
        for i in range(1, m.nbody):
            self._tree(i)
        springs, stops = self._springs(), self._stops()
        actuators, more = self._actuators()
        ropes, struts = self._tendons()
        self._list()
        sites = {self._name("site", i): self._site(i)[0] for i in range(m.nsite)}
        system = System(
            tuple(self.bodies), tuple(self.joints), (*springs, *more), tuple(stops), ropes=tuple(ropes),
            forces=(*actuators, *struts), gravity=self.gravity,
        )  # fmt: skip
        return FromMujoco(system, sites, self.missing)

    def _name(self, kind: str, i: int) -> str:
        given = self.library.mj_id2name(self.m, getattr(self.library.mjtObj, f"mjOBJ_{kind.upper()}"), i)
        return given or f"{kind}{i}"

    def _tree(self, i: int) -> None:
        """Convert body i and its joints; between two joints of a body there is a massless body."""
        m = self.m
        R = self.matrix(m.body_iquat[i])
        inertia = R * m.body_inertia[i] @ R.T
        own = Body(self.body[i], float(m.body_mass[i]), row_of(m.body_ipos[i]), _rows(0.5 * (inertia + inertia.T)))
        place, turn, parent = m.body_pos[i], self.matrix(m.body_quat[i]), self.body[m.body_parentid[i]]
        held = [k for k in range(m.njnt) if m.jnt_bodyid[k] == i]
        if not held:
            self.joints.append(Joint(f"{own.name}-fixed", "fixed", parent, own.name, row_of(place), _rows(turn)))
        for n, k in enumerate(held):
            child = own.name if n == len(held) - 1 else f"{own.name}-{n + 1}"
            if child != own.name:
                self.bodies.append(Body(child, 0.0))
            kind, anchor = KINDS[int(m.jnt_type[k])], m.jnt_pos[k]
            if kind == "free":
                x, y, z, qw, qx, qy, qz = row_of(m.qpos0[m.jnt_qposadr[k] :][:7])
                self.joints.append(Joint(self.joint[k], "free", self.body[0], child, q0=(x, y, z, qx, qy, qz, qw)))
            else:
                q0 = (0.0, 0.0, 0.0, 1.0) if kind == "spherical" else (0.0,)
                at, axis = row_of(place + turn @ anchor), row_of(m.jnt_axis[k])
                self.joints.append(
                    Joint(self.joint[k], kind, parent, child, at, _rows(turn), axis, q0=q0, p_CJ=row_of(anchor))
                )
            parent, place, turn = child, np.zeros(3), np.eye(3)
        self.bodies.append(own)

    def _single(self, k: int) -> bool:
        return int(self.m.jnt_type[k]) in (SLIDE, HINGE)

    def _springs(self) -> list[JointSpring]:
        m, out = self.m, []
        for k, name in enumerate(self.joint):
            q, v = m.jnt_qposadr[k], m.jnt_dofadr[k]
            stiffness, damping = float(m.jnt_stiffness[k]), float(m.dof_damping[v])
            if not (stiffness or np.any(m.dof_damping[m.dof_jntid == k])):
                continue
            if not self._single(k):
                self._lacks(f"joint '{name}'", "springs and dampers of joints that turn freely")
                continue
            rest = float(m.qpos_spring[q] - m.qpos0[q])
            out.append(JointSpring(f"{name}-spring", name, stiffness, damping, rest))
        return out

    def _stops(self) -> list[Stop]:
        m, out = self.m, []
        for k, name in enumerate(self.joint):
            if not m.jnt_limited[k]:
                continue
            if not self._single(k):
                self._lacks(f"joint '{name}'", "limits of joints that turn freely")
                continue
            zero, inertia = float(m.qpos0[m.jnt_qposadr[k]]), 1.0 / float(m.dof_invweight0[m.jnt_dofadr[k]])
            lower, upper = (float(x) - zero for x in m.jnt_range[k])
            k_, d = _reference(m.jnt_solref[k], m.jnt_solimp[k])
            out.append(Stop(f"{name}-limit", name, lower, upper, inertia * k_, inertia * d))
        return out

    def _actuators(self) -> tuple[list[forces.Force], list[JointSpring]]:
        """Return the actuators as forces gear * (gain * control + bias), where control is a signal that starts at 0,
        and as joint springs."""
        m, out, springs = self.m, list[forces.Force](), list[JointSpring]()
        for i, group in enumerate(m.actuator_group):
            if self._off("ACTUATION") or (0 <= group <= GROUPS and m.opt.disableactuator >> int(group) & 1):
                continue
            name, gear = self._name("actuator", i), m.actuator_gear[i]
            gain, bias = float(m.actuator_gainprm[i][0]), [float(x) for x in m.actuator_biasprm[i][:3]]
            if not m.actuator_biastype[i]:
                bias = [0.0, 0.0, 0.0]
            on, target = int(m.actuator_trntype[i]), m.actuator_trnid[i]
            plain = not m.actuator_dyntype[i] and not m.actuator_gaintype[i] and int(m.actuator_biastype[i]) < 2
            control = forces.InputSignal(0.0, driven=True)
            if plain and on in ON_JOINT and self._single(target[0]) and max(bias[1:]) <= 0.0:
                joint, g = self.joint[target[0]], float(gear[0])
                out.append(forces.Characteristic(name, joint, "position", (-1.0, 1.0), (gain * g, gain * g), control))
                k, d, zero = -bias[1] * g * g, -bias[2] * g * g, float(m.qpos0[m.jnt_qposadr[target[0]]])
                if k or d:
                    springs.append(JointSpring(f"{name}-bias", joint, k, d, bias[0] * g / k - zero if k else 0.0))
                if bias[0] and not k:
                    out.append(
                        forces.Characteristic(f"{name}-bias", joint, "position", (-1.0, 1.0), (bias[0] * g,) * 2)
                    )
            elif plain and on == ON_SITE and target[1] < 0 and not any(bias):
                point, R = self._site(target[0])
                push, twist = (row_of(gain * R @ gear[at]) for at in (slice(0, 3), slice(3, 6)))
                out.append(forces.Load(name, point, push, twist, "body", control))
            else:
                self._lacks(
                    f"actuator '{name}'", "actuators with states of their own, on tendons, or of user functions"
                )
                continue
            if m.actuator_ctrllimited[i] or m.actuator_forcelimited[i]:
                self._lacks(
                    f"actuator '{name}'", "limits of controls and of forces of actuators, which are not kept to"
                )
        return out, springs

    def _tendons(self) -> tuple[list[Rope], list[forces.Force]]:
        """Return the spatial tendons through sites and pulleys: as ropes that only pull, or struts that also push."""
        m, ropes, struts = self.m, list[Rope](), list[forces.Force]()
        wrapped = WrappedTendons(self.library, m, self.body) if m.ntendon else None
        for i in range(m.ntendon):
            name, (low, high) = self._name("tendon", i), (float(x) for x in m.tendon_lengthspring[i])
            k, d = float(m.tendon_stiffness[i]), float(m.tendon_damping[i])
            if m.tendon_limited[i] or m.tendon_frictionloss[i]:
                self._lacks(f"tendon '{name}'", "limits and friction of tendons")
            if not (k or d):
                self._lacks(f"tendon '{name}'", "tendons without a spring or damper")
                continue
            lines = self._path(i)
            if lines and not low and high > 0.0 and k:
                ropes.append(Rope(name, tuple(lines), k * high, high, d))
                if d:
                    self._lacks(f"tendon '{name}'", "dampers of slack tendons: ropes damp while they are taut")
            elif wrapped and not lines and not low and high > 0.0 and k and (over := wrapped.rope(i, name, k, high, d)):
                struts.append(over)
            elif len(lines) == 1 and lines[0].share == 1.0 and low == high:
                struts.append(forces.Spring(name, lines[0].a, lines[0].b, high, k, d))
            else:
                what = "tendons over joints or in space around geoms, and springs over several sites that push, too"
                self._lacks(f"tendon '{name}'", what)
        return ropes, struts

    def _path(self, i: int) -> list[Line]:
        """Return the lines of tendon i from site to site, with their shares; none if it also wraps around bodies."""
        m, lines, share = self.m, list[Line](), 1.0
        last: Point | None = None
        for w in range(m.tendon_adr[i], m.tendon_adr[i] + m.tendon_num[i]):
            kind = int(m.wrap_type[w])
            if kind == PULLEY:
                share, last = 1.0 / float(m.wrap_prm[w]), None
            elif kind == SITE:
                here = self._site(m.wrap_objid[w])[0]
                if last:
                    lines.append(Line(last, here, share))
                last = here
            else:
                return []
        return lines

    def _site(self, i: int) -> tuple[Point, np.ndarray]:
        """Return the point of site i on its body, and its axes in the frame of the body."""
        m = self.m
        return Point(self.body[m.site_bodyid[i]], row_of(m.site_pos[i])), self.matrix(m.site_quat[i])

    def matrix(self, quaternion: np.ndarray) -> np.ndarray:
        """Return the rotation matrix (3, 3) of a quaternion (w, x, y, z)."""
        R = np.zeros(9)
        self.library.mju_quat2Mat(R, quaternion)
        return R.reshape(3, 3)

    def _lacks(self, of: str, what: str) -> None:
        self.missing.append(f"{of}: {what}")

    def _list(self) -> None:
        """List the features that are not converted."""
        m = self.m
        for kind, field, what in UNLIKE:
            rows = [k for k, x in enumerate(getattr(m, field, ())) if np.any(x)]
            owners = [int(m.dof_jntid[v]) for v in rows] if field.startswith("dof_") else rows
            for i in dict.fromkeys(owners):
                self._lacks(f"{kind} '{self._name(kind, i)}'", what)
        collide = int(sum(bool(a or b) for a, b in zip(m.geom_contype, m.geom_conaffinity, strict=True)))
        counted = {
            "geoms that collide": (not self._off("CONTACT")) * collide,
            "pairs of geoms that collide": (not self._off("CONTACT")) * m.npair,
            "equality constraints": (not self._off("EQUALITY")) * m.neq, "flexible parts": m.nflex,
            "plugins": m.nplugin, "bodies that are placed from outside": m.nmocap, "sensors": m.nsensor,
            "keyframes": m.nkey, "cameras and lights": m.ncam + m.nlight,
        }  # fmt: skip
        self.missing += [f"{n} {what}" for what, n in counted.items() if n]
        if m.opt.density or m.opt.viscosity:
            self.missing.append("forces of the medium")


def _reference(solref: np.ndarray, solimp: np.ndarray) -> tuple[float, float]:
    """Return the stiffness and damping per inertia of a soft limit, by the formulas in MuJoCo's documentation of
    `solref`."""
    first, second, most = float(solref[0]), float(solref[1]), float(solimp[1])
    if first <= 0.0:
        return -first / (most * most), -second / most
    return 1.0 / (most * most * first * first * second * second), 2.0 / (most * first)


def _rows(R: np.ndarray) -> Any:
    return tuple(row_of(r) for r in R)
