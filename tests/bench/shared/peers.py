"""The two-crane reference scene in MuJoCo and Pinocchio, and the time of one evaluation there.

MuJoCo: `mj_forward` in a loop of machine code.  Pinocchio: `aba` without ropes, on one thread, by its own batch
call over many states (`abaInParallel`), so that no Python is inside either.  Its constrained dynamics have no batch
call: what the same call costs for one joint without constraints is taken off.
"""

import ctypes
from dataclasses import replace
from pathlib import Path

import numpy as np
from goliath import HINGE_DAMPING, KP, KV, G
from heavylift.kernel.multibody import build_graph

from .native_loops import fastest, foreign
from .rows import peer_module

TEST = "pip install '.[test]'"
mujoco, pin = peer_module("mujoco", "MuJoCo", TEST), peer_module("pinocchio", "Pinocchio", TEST)


def mjcf(system, integrator, h, pins=()):
    """MJCF text; ropes are tendons with a dead band up to their rest length; pins: parent, child, place on parent."""
    bodies = {b.name: b for b in system.bodies}
    sites = {f"{r.name}-{e}": getattr(r.lines[0], e) for r in system.ropes for e in "ab"}

    def numbers(x):
        return " ".join(repr(float(e)) for e in x)

    def body(joint):
        b = bodies[joint.child]
        k, d = (KP, KV) if joint.kind == "prismatic" else (0.0, HINGE_DAMPING)
        kind = {"prismatic": "slide", "revolute": "hinge"}.get(joint.kind)
        move = f'<joint type="{kind}" axis="{numbers(joint.axis)}" stiffness="{k}" damping="{d}"/>'
        marks = "".join(f'<site name="{n}" pos="{numbers(p.p)}"/>' for n, p in sites.items() if p.body == b.name)
        inertia = numbers(b.inertia[i][i] for i in range(3))
        return (
            f'<body name="{b.name}" pos="{numbers(joint.p_PJ if kind else joint.q0[:3])}">'
            f"{move if kind else '<freejoint/>'}{marks}"
            f'<inertial pos="{numbers(b.com)}" mass="{b.mass}" diaginertia="{inertia}"/>'
            f"{''.join(body(j) for j in system.joints if j.parent == b.name)}</body>"
        )

    tendons = "".join(
        f'<spatial name="{r.name}" springlength="0 {r.L0!r}" stiffness="{r.EA / r.L0!r}" damping="{r.damping}">'
        f'<site site="{r.name}-a"/><site site="{r.name}-b"/></spatial>'
        for r in system.ropes
    )
    connected = "".join(f'<connect body1="{a}" body2="{b}" anchor="{numbers(p)}"/>' for a, b, p in pins)
    return (
        f'<mujoco><option gravity="0 0 -{G}" integrator="{integrator}" timestep="{h!r}">'
        '<flag contact="disable" energy="disable"/></option><compiler angle="radian"/>'
        f"<worldbody>{''.join(body(j) for j in system.joints if j.parent == 'world')}</worldbody>"
        f"<tendon>{tendons}</tendon><equality>{connected}</equality></mujoco>"
    )


class MuJoCo:
    """The scene at its start."""

    def __init__(self, system, integrator="RK4", h=0.01, pins=()):
        self.system = system
        self.model = mujoco.MjModel.from_xml_string(mjcf(system, integrator, h, pins))
        self.data = mujoco.MjData(self.model)
        free = next(j for j in system.joints if j.kind == "free")
        at = self.model.body_dofadr[self.model.body(free.child).id]
        self.data.qvel[at : at + 6] = free.v0
        mujoco.mj_forward(self.model, self.data)

    def forward(self):
        """Seconds of one mj_forward."""
        library = ctypes.CDLL(str(next(Path(mujoco.__file__).parent.glob("libmujoco.so*"))))
        address = ctypes.cast(library.mj_forward, ctypes.c_void_p).value
        return foreign(address, self.model._address, self.data._address)

    def tensions(self):
        """(ropes,) [N]."""
        mujoco.mj_forward(self.model, self.data)
        length, rate = self.data.ten_length, self.data.ten_velocity
        ids = [self.model.tendon(r.name).id for r in self.system.ropes]
        return np.array(
            [
                r.EA / r.L0 * (length[i] - r.L0) + r.damping * rate[i]
                for r, i in zip(self.system.ropes, ids, strict=True)
            ]
        )


def pinocchio_aba(graph):
    """Seconds of one `aba` without external forces."""
    from random_trees import pinocchio_model

    model = pinocchio_model(graph, G)
    pool = pin.ModelPool(model, 1)
    n = 500
    q = np.asfortranarray(np.tile(pin.neutral(model)[:, None], n))
    v, tau, a = (np.asfortranarray(np.full((model.nv, n), x)) for x in (0.01, 0.0, 0.0))
    return fastest(lambda _: pin.abaInParallel(1, pool, q, v, tau, a), 1) / n


def cut_loose(system):
    """The scene with each loader free, and its pins, two in line for each: parent, child, place on the parent."""
    block = next(j for j in system.joints if j.child == "block")
    joints, pins = [], []
    for j in system.joints:
        if j.parent == "block":
            x, y, z = j.p_PJ
            pins += [("block", j.child, (x + d, y, z)) for d in (-0.5, 0.5)]
            at = tuple(a + b for a, b in zip(block.q0, j.p_PJ, strict=False))
            joints.append(replace(j, kind="free", parent="world", p_PJ=(0.0, 0.0, 0.0), q0=(*at, 0.0, 0.0, 0.0, 1.0)))
        else:
            joints.append(j)
    springs = tuple(x for x in system.springs if not x.joint.startswith("low"))
    return replace(system, joints=tuple(joints), springs=springs), pins


def pinocchio_constrained(system):
    """Seconds of one `constraintDynamics` and of one `lcaba` of the scene cut loose, without ropes, by name."""
    if pin is None:
        return dict.fromkeys(("constraintDynamics", "lcaba"))
    from random_trees import pinocchio_model

    loose, pins = cut_loose(system)
    model = pinocchio_model(build_graph(loose), G)
    q, v, at = pin.neutral(model), np.full(model.nv, 0.01), {}
    for j, i in zip(loose.joints, range(1, model.njoints), strict=True):
        at[j.child] = i
        if j.kind == "free":
            q[model.idx_qs[i] : model.idx_qs[i] + 7] = j.q0
    tau = np.zeros(model.nv)
    models = pin.StdVec_RigidConstraintModel()
    for parent, child, place in pins:
        offset = np.array([place[0] - next(j for j in system.joints if j.child == child).p_PJ[0], 0.0, 0.0])
        a, b = (pin.SE3(np.eye(3), np.array(x, float)) for x in (place, offset))
        models.append(
            pin.RigidConstraintModel(
                pin.ContactType.CONTACT_3D, model, at[parent], a, at[child], b, pin.ReferenceFrame.LOCAL
            )
        )
    one = pin.Model()
    one.appendBodyToJoint(
        one.addJoint(0, pin.JointModelRX(), pin.SE3.Identity(), "x"), pin.Inertia.Identity(), pin.SE3.Identity()
    )
    none = pin.StdVec_RigidConstraintModel()
    out = {}
    for compute in (pin.constraintDynamics, pin.lcaba):
        costs = []
        for m, constraints, x in ((model, models, (q, v, tau)), (one, none, (np.zeros(1),) * 3)):
            data, settings = m.createData(), pin.ProximalSettings(1e-10, 1e-6, 3)
            datas = pin.StdVec_RigidConstraintData()
            for c in constraints:
                datas.append(c.createData())
            if compute is pin.lcaba:
                pin.computeJointMinimalOrdering(m, data, constraints)
            else:
                pin.initConstraintDynamics(m, data, constraints, datas)

            def work(times, m=m, data=data, x=x, c=constraints, d=datas, s=settings, compute=compute):
                for _ in range(times):
                    compute(m, data, *x, c, d, s)

            costs.append(fastest(work, 500))
        out[compute.__name__] = costs[0] - costs[1]
    return out
