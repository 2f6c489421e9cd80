"""Each number that changes a MuJoCo model's accelerations changes those of the import, or is listed."""

from copy import copy

import mujoco
import numpy as np
import pytest
from heavylift import from_mujoco
from heavylift.kernel.multibody import build_graph
from mujoco_peer import accelerations, placed, state_of, theirs_as_ours

MODEL = mujoco.MjModel.from_xml_string("""<mujoco><option gravity="0 0 -9.80665"/><default>
<geom contype="0" conaffinity="0"/></default><worldbody><site name="w" pos="-1 0.2 1"/><body name="a" pos="0 0 1">
<joint name="h" axis="0 1 0.2" stiffness="3" springref="10" damping="0.5" limited="true" range="-90 90"/>
<inertial pos="0.1 0.2 -0.5" mass="2" diaginertia=".3 .4 .5"/><geom size="0.1" mass="0"/><site name="s" pos=".1 0 -.3"/>
<body name="b" pos="0 0 -1" quat="0.9 0.1 0.2 0.3">
<joint name="l" type="slide" axis="0 0 1" stiffness="30" damping="2" pos="0.1 0 0"/>
<inertial pos="0 0.1 -0.3" mass="1" diaginertia=".2 .2 .3"/><site name="t" pos="0 .2 0" quat=".8 .1 .1 .5"/></body>
</body><body name="c" pos="1 0 2"><joint name="o" type="ball"/><inertial pos="0 0 -1" mass="1" diaginertia=".2 .2 .3"/>
<site name="u" pos="0 0 -1"/></body><body name="d" pos="2 0 0"><freejoint name="f"/>
<inertial pos="0 0.1 0" mass="1" diaginertia=".2 .2 .3"/><site name="v" pos="0 0.2 0"/></body></worldbody><tendon>
<spatial name="rope" stiffness="40" springlength="0 0.3"><site site="s"/><site site="u"/><site site="v"/></spatial>
<spatial name="strut" stiffness="50" springlength="0.5" damping="0.7"><site site="w"/><site site="t"/></spatial>
<spatial name="idle"><site site="w"/><site site="t"/></spatial><fixed name="sum"><joint joint="h" coef="1"/></fixed>
</tendon><actuator><motor name="m" joint="h" gear="2"/><position name="p" joint="l" kp="5" kv="0.3"/>
<velocity name="q" joint="h" kv="0.4" group="2"/>
<general name="g" site="v" gear="1 2 3 0.4 0.5 0.6" gainprm="1.3"/></actuator></mujoco>""")
STATE = state_of(build_graph(from_mujoco(MODEL).system), MODEL, np.random.default_rng(3))
CONTROLS = {"m": 0.4, "p": -0.7, "q": 0.9, "g": 1.3}
SAME = 1e-9  # relative to the largest acceleration
DIRECTIONS = ("body_quat", "body_iquat", "site_quat", "jnt_axis")
SOFT = {("jnt_limited", 1)}  # a limit of range 0, which MuJoCo keeps to by a constraint and heavylift by a spring
START = {"qpos0"}  # from which heavylift counts coordinates
KINDS = ("actuator_", "body_", "dof_", "jnt_", "tendon_", "site_", "geom_", "qpos")


def theirs(model) -> np.ndarray:
    data = mujoco.MjData(model)
    mujoco.mj_setConst(model, data)
    mujoco.mj_resetData(model, data)
    data.qpos[:], data.qvel[:], data.ctrl[:] = STATE[0], STATE[1], list(CONTROLS.values())
    mujoco.mj_forward(model, data)
    return data.qacc.copy()


def same(a, b) -> bool:
    return bool(np.abs(a - b).max() <= SAME * (1.0 + np.abs(b).max()))


def check(model) -> str:
    """Return whether a changed model is `equal`, `listed` or `unchanged`; otherwise fail."""
    want = theirs(model)
    if same(want, theirs(copy(MODEL))):
        return "unchanged"
    system, _, missing = from_mujoco(model)
    if {*missing} - {*from_mujoco(MODEL).missing}:
        return "listed"
    ours = accelerations(placed(system, STATE[2], STATE[3], CONTROLS))
    assert same(ours, theirs_as_ours(build_graph(system), model, STATE[0], want, STATE[3]))
    return "equal"


def numbers_of(model) -> list[str]:
    """The fields of switches and numbers with a row for each object."""
    fields = ((name, getattr(model, name)) for name in sorted(dir(model)) if name.startswith(KINDS))
    return [name for name, x in fields if isinstance(x, np.ndarray) and x.size and x.dtype.kind in "fb"]


def test_each_number_in_a_mujoco_model_is_imported_or_listed_as_not_imported():
    found = {"equal": 0, "listed": 0, "unchanged": 0}
    for field in numbers_of(MODEL):
        for row in range(len(getattr(MODEL, field))):
            if (field, row) in SOFT or field in START:
                continue
            model = copy(MODEL)
            values = getattr(model, field)
            values[row] = ~values[row] if values.dtype.kind == "b" else values[row] * 1.1 + 0.01
            if field in DIRECTIONS:
                values[row] /= np.linalg.norm(values[row])
            found[check(model)] += 1
    assert min(found.values()) >= 30  # none of the three cases is empty


@pytest.mark.parametrize("flag", [x for x in dir(mujoco.mjtDisableBit) if x.startswith("mjDSBL_")])
def test_of_the_disable_flags_of_mujoco_only_the_four_supported_ones_change_the_import(flag):
    model = copy(MODEL)
    model.opt.disableflags = int(getattr(mujoco.mjtDisableBit, flag))
    assert (check(model) != "unchanged") == (flag[7:] in ("ACTUATION", "DAMPER", "GRAVITY", "SPRING"))


def test_groups_of_actuators_that_a_mujoco_model_disables_do_not_act():
    model = copy(MODEL)
    model.opt.disableactuator = 1 << 2
    assert check(model) == "equal"
    assert not [x for x in from_mujoco(model).system.springs if x.name.startswith("q")]
    for group in (-1, 31):  # which cannot be disabled
        model.actuator_group[2] = group
        model.opt.disableactuator = -1
        assert check(model) == "equal"
        assert [x for x in from_mujoco(model).system.springs if x.name.startswith("q")]


@pytest.mark.parametrize("seed", range(4))
def test_an_imported_mujoco_model_with_inclined_gravity_is_rotated_so_that_gravity_is_vertical(seed):
    model = copy(MODEL)
    model.opt.gravity[:] = np.random.default_rng(seed).normal(size=3) * 9.0 if seed else (0.0, 0.0, 9.0)
    assert check(model) == "equal"
    assert from_mujoco(model).system.gravity == pytest.approx(np.linalg.norm(model.opt.gravity))


@pytest.mark.parametrize("name", ["density", "viscosity"])
def test_density_and_viscosity_of_a_mujoco_model_are_listed_as_not_imported(name):
    model = copy(MODEL)
    setattr(model.opt, name, 1.2)
    assert check(model) == "listed"
