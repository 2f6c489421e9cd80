"""Conversion between MuJoCo's states and accelerations and heavylift's."""

import re
from dataclasses import replace

import msgspec
import mujoco
import numpy as np
from heavylift.kernel.description import InputSignal, System
from heavylift.kernel.multibody import build_graph
from heavylift.kernel.simulation import Simulation

ACTUATOR, BODY, JOINT, TENDON = (getattr(mujoco.mjtObj, f"mjOBJ_{x}") for x in ("ACTUATOR", "BODY", "JOINT", "TENDON"))
WITHIN = 0.1  # part of a joint's range at each end that a state leaves out: limits are soft there


def names_of(model, kind, count: int) -> list[str]:
    """The names of objects as the import gives them."""
    word = kind.name.removeprefix("mjOBJ_").lower()
    return [mujoco.mj_id2name(model, kind, i) or f"{word}{i}" for i in range(count)]


def state_of(graph, model, r) -> tuple[np.ndarray, ...]:
    """A random state within the limits, as MuJoCo and as heavylift have it: qpos, qvel; q, v."""
    qpos, qvel = model.qpos0.copy(), r.normal(size=model.nv)
    q, v = np.zeros(graph.nq), np.zeros(graph.nv)
    for k, j in joints(graph, model):
        a, d = model.jnt_qposadr[j], model.jnt_dofadr[j]
        kind = k.joint.kind
        if kind in ("revolute", "prismatic"):
            low, high = model.jnt_range[j]
            inside = low + (high - low) * r.uniform(WITHIN, 1.0 - WITHIN)
            q[k.q] = inside - qpos[a] if model.jnt_limited[j] else r.normal()
            qpos[a] += q[k.q][0]
            v[k.v] = qvel[d]
            continue
        turn = r.normal(size=4)
        turn /= np.linalg.norm(turn)
        start = 3 if kind == "free" else 0
        qpos[a + start : a + start + 4] = turn
        q[k.q.start + start : k.q.stop] = turn[[1, 2, 3, 0]]
        v[k.v] = qvel[d : d + 3 + start]
        if start:
            qpos[a : a + 3] = r.normal(size=3)
            q[k.q.start : k.q.start + 3] = qpos[a : a + 3]
            v[k.v.start : k.v.start + 3] = rotation(turn).T @ qvel[d : d + 3]
    return qpos, qvel, q, v


def joints(graph, model):
    """Pairs of heavylift's link and MuJoCo's joint."""
    index = {name: j for j, name in enumerate(names_of(model, JOINT, model.njnt))}
    return [(k, index[k.joint.name]) for k in graph.links if k.joint.name in index]


def rotation(quaternion) -> np.ndarray:
    R = np.zeros(9)
    mujoco.mju_quat2Mat(R, quaternion)
    return R.reshape(3, 3)


def theirs_as_ours(graph, model, qpos, qacc, v) -> np.ndarray:
    """MuJoCo's accelerations as rates of heavylift's velocities."""
    out = np.zeros(graph.nv)
    for k, j in joints(graph, model):
        a, d = model.jnt_qposadr[j], model.jnt_dofadr[j]
        out[k.v] = qacc[d : d + k.v.stop - k.v.start]
        if k.joint.kind == "free":
            R, own = rotation(qpos[a + 3 : a + 7]), v[k.v]
            out[k.v.start : k.v.start + 3] = R.T @ qacc[d : d + 3] - np.cross(own[3:], own[:3])
    return out


def placed(system: System, q, v, control: dict[str, float]) -> System:
    graph = build_graph(system)
    at = {k.joint.name: replace(k.joint, q0=tuple(q[k.q]), v0=tuple(v[k.v])) for k in graph.links}
    moved = [
        msgspec.structs.replace(f, signal=InputSignal(control[f.name], driven=True)) if f.name in control else f
        for f in system.forces
    ]
    return replace(system, joints=tuple(at[j.name] for j in system.joints), forces=tuple(moved))


def accelerations(system: System) -> np.ndarray:
    simulation = Simulation(system)
    simulation.start()
    p = simulation.program
    return simulation.native.part("f")[p.nq : p.nq + p.nv].copy()


def compared(system: System, model, data, r) -> tuple[np.ndarray, np.ndarray]:
    """The accelerations of heavylift and of MuJoCo in a random state, with random controls."""
    graph = build_graph(system)
    qpos, qvel, q, v = state_of(graph, model, r)
    data.qpos[:], data.qvel[:], data.ctrl[:] = qpos, qvel, r.normal(size=model.nu)
    mujoco.mj_forward(model, data)
    names = names_of(model, ACTUATOR, len(model.actuator_trntype))
    controls = dict(zip(names, (float(data.ctrl[k]) for k in control_of(model)), strict=True))
    return accelerations(placed(system, q, v, controls)), theirs_as_ours(graph, model, qpos, data.qacc, v)


def control_of(model):
    """The first control of each actuator; before MuJoCo 4, each has one."""
    return getattr(model, "actuator_ctrladr", range(model.nu))


def switched_off(model, data, missing: list[str]) -> None:
    """Switch off in MuJoCo what an import lists as missing; a sentence that is not known here is an error."""
    index = {
        word: {name: i for i, name in enumerate(names_of(model, kind, count))}
        for word, kind, count in (
            ("joint", JOINT, model.njnt), ("tendon", TENDON, model.ntendon), ("body", BODY, model.nbody),
            ("actuator", ACTUATOR, len(model.actuator_trntype)),
        )
    }  # fmt: skip
    for sentence in missing:
        if found := re.fullmatch(r"(joint|tendon|body|actuator) '(.*)': (.*)", sentence):
            kind, what, i = found[1], found[3], index[found[1]][found[2]]
            dofs = model.dof_jntid == i
            match kind, what.split(" ")[0]:
                case "joint", "armature":
                    model.dof_armature[dofs] = 0.0
                case "joint", "dry":
                    model.dof_frictionloss[dofs] = 0.0
                case "joint", "springs":
                    model.jnt_stiffness[i], model.dof_damping[dofs] = 0.0, 0.0
                case "joint", "limits" if "of joints" in what:
                    model.jnt_limited[i] = False
                case "joint", "limits":
                    model.jnt_actfrclimited[i] = False
                case "joint", "margins":  # states stay within the limits
                    pass
                case "tendon", "tendons" | "dampers":
                    model.tendon_damping[i] = 0.0
                    model.tendon_stiffness[i] *= what.startswith("dampers")
                case "tendon", "limits":
                    model.tendon_limited[i], model.tendon_frictionloss[i] = False, 0.0
                case "actuator", "limits":
                    model.actuator_ctrllimited[i] = model.actuator_forcelimited[i] = False
                case "actuator", "actuators":
                    model.actuator_gainprm[i], model.actuator_biasprm[i] = 0.0, 0.0
                    model.actuator_gaintype[i] = model.actuator_biastype[i] = 0
                case "body", "compensation":
                    model.body_gravcomp[i] = 0.0
                case _:
                    raise ValueError(sentence)
        elif "geoms that collide" in sentence:
            model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
        elif "equality constraints" in sentence:
            model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_EQUALITY)
        elif sentence == "forces of the medium":
            model.opt.density = model.opt.viscosity = 0.0
        elif not re.match(r"shape of|\d+ (sensors|keyframes|cameras and lights|bodies that are placed)", sentence):
            raise ValueError(sentence)
    mujoco.mj_setConst(model, data)
