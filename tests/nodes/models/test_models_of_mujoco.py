"""Models in MJCF and URDF become systems with MuJoCo's accelerations; features without equivalent are listed."""

from dataclasses import replace
from math import pi

import heavylift
import mujoco
import numpy as np
import pytest
from heavylift import from_mujoco, linearise
from heavylift.kernel import SceneError
from heavylift.kernel.multibody import build_graph
from mujoco_peer import compared, placed

G = '<option gravity="0 0 -9.80665"/>'
OFF = '<default><geom contype="0" conaffinity="0"/></default>'


def numbers(x) -> str:
    return " ".join(f"{float(e):.17g}" for e in np.atleast_1d(x))


def random_model(seed: int) -> str:
    """A tree of bodies with all joints, springs, dampers, references, actuators and tendons, frames askew."""
    r = np.random.default_rng(seed)
    actuators, tendons, sites = [], [], []

    def body(i: int, depth: int) -> str:
        joints = []
        if depth == 0 and r.random() < 0.3:
            joints.append(f'<freejoint name="j{i}"/>')
        else:
            for n in range(int(r.integers(0 if depth else 1, 3))):
                kind = ["hinge", "slide", "ball"][int(r.choice(3, p=[0.5, 0.3, 0.2]))]
                name = f"j{i}-{n}"
                text = f'<joint name="{name}" type="{kind}" pos="{numbers(r.normal(size=3))}"'
                if kind != "ball":
                    text += f' axis="{numbers(r.normal(size=3))}" ref="{r.normal():.6f}"'
                    text += (
                        f' stiffness="{r.uniform(0, 9):.6f}" springref="{r.normal():.6f}" damping="{r.uniform():.6f}"'
                    )
                    gear = f'gear="{r.uniform(0.5, 3):.6f}"'
                    kinds = ["motor", 'position kp="3" kv="0.4"', 'velocity kv="0.7"']
                    what = kinds[int(r.integers(3))].split(" ", 1)
                    actuators.append(f'<{what[0]} name="a{name}" joint="{name}" {gear} {" ".join(what[1:])}/>')
                joints.append(text + "/>")
                if kind == "ball":
                    break
        a, b, c = np.sort(r.uniform(0.5, 1.0, 3))
        inertial = f'<inertial pos="{numbers(r.normal(size=3))}" quat="{numbers(r.normal(size=4))}" '
        inertial += f'mass="{r.uniform(0.5, 4):.6f}" diaginertia="{a:.6f} {b:.6f} {min(c, 0.99 * (a + b)):.6f}"/>'
        sites.append(f"s{i}")
        site = f'<site name="s{i}" pos="{numbers(r.normal(size=3))}" quat="{numbers(r.normal(size=4))}"/>'
        inner = "".join(body(2 * i + k, depth + 1) for k in (1, 2) if depth < 3 and r.random() < 0.7)
        place = f'pos="{numbers(r.normal(size=3))}" quat="{numbers(r.normal(size=4))}"'
        return f'<body name="b{i}" {place}>{"".join(joints)}{inertial}{site}{inner}</body>'

    world = body(1, 0) + body(40, 0)
    for n in range(4):  # a strut, ropes through several sites, the last one over a pulley
        through = [sites[int(k)] for k in r.permutation(len(sites))[: 2 + n]]
        path = [f'<site site="{s}"/>' for s in through]
        if n == 3 and len(path) == 5:
            path.insert(3, '<pulley divisor="2"/>' + path[2])
        spring, damping = ("0 0.3", "") if n else ("0.7", f'damping="{r.uniform():.5f}"')
        stiffness = f'stiffness="{r.uniform(1, 5):.5f}"'
        if len(path) > 1:
            tendons.append(
                f'<spatial name="t{n}" {stiffness} springlength="{spring}" {damping}>{"".join(path)}</spatial>'
            )
    for n, s in enumerate(sites[:2]):
        actuators.append(f'<general name="thrust{n}" site="{s}" gear="{numbers(r.normal(size=6))}" gainprm="1.7"/>')
    return (
        f"<mujoco>{G}{OFF}<worldbody>{world}</worldbody><tendon>{''.join(tendons)}</tendon>"
        f"<actuator>{''.join(actuators)}</actuator></mujoco>"
    )


@pytest.mark.large(beyond=6)
@pytest.mark.parametrize("seed", range(20))
def test_models_imported_from_mujoco_have_its_accelerations_at_random_states(seed, tmp_path):
    file = tmp_path / "model.xml"
    file.write_text(random_model(seed))
    system, _, missing = from_mujoco(file)
    assert missing == []
    model = mujoco.MjModel.from_xml_path(str(file))
    ours, want = compared(system, model, mujoco.MjData(model), np.random.default_rng(seed))
    assert len(want) == model.nv
    assert ours == pytest.approx(want, abs=1e-9 * (1.0 + np.abs(want).max()))


URDF = """<robot name="arm"><link name="base"/>{}</robot>""".format(
    "".join(
        f"""<link name="l{i}"><inertial><origin xyz="0.1 0 -0.4" rpy="0 0 0.3"/><mass value="{1 + i}"/>
<inertia ixx=".1" iyy=".12" izz=".05" ixy="0.01" ixz="0" iyz="0"/></inertial></link>
<joint name="j{i}" type="{"prismatic" if i == 2 else "revolute"}"><parent link="{"base" if i == 0 else f"l{i - 1}"}"/>
<child link="l{i}"/><origin xyz="0 0.1 -0.8" rpy="0.2 0.1 {i}"/><axis xyz="{"0 0 1" if i == 2 else "0.6 0.8 0"}"/>
<limit lower="-100" upper="100" effort="1" velocity="1"/><dynamics damping="0.3"/></joint>"""
        for i in range(5)
    )
)


def test_an_arm_imported_from_urdf_moves_as_in_mujoco(tmp_path):
    file = tmp_path / "arm.urdf"
    file.write_text(URDF)
    model = mujoco.MjModel.from_xml_path(str(file))
    model.opt.integrator, model.opt.timestep = mujoco.mjtIntegrator.mjINT_RK4, 2e-4
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 5000)
    system = replace(from_mujoco(file).system, gravity=9.81)
    found = heavylift.simulate(system, until=1.0, tolerance=1e-10)["joint/position"]
    assert found.values[-1] == pytest.approx(data.qpos, abs=1e-8)


CART = f"""<mujoco>{G}<option timestep="1e-6" integrator="Euler"/>{OFF}<worldbody><body name="cart">
<joint name="rail" type="slide" axis="1 0 0" damping="0.4"/><inertial pos="0 0 0" mass="3" diaginertia="1 1 1"/>
<body name="rod"><joint name="pin" axis="0 1 0" damping="0.1"/>
<inertial pos="0.1 0 -1" mass="2" diaginertia=".1 .1 .1"/><body name="tip" pos="0 0 -2"><joint name="tip" axis="0 1 0"/>
<inertial pos="0 0 -1" mass="1" diaginertia=".1 .1 .1"/>
</body></body></body></worldbody><actuator><motor name="push" joint="rail" gear="2"/></actuator></mujoco>"""


def test_linear_models_of_imported_systems_agree_with_finite_differences_by_mujoco(tmp_path):
    file = tmp_path / "cart.xml"
    file.write_text(CART)
    model = mujoco.MjModel.from_xml_path(str(file))
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP)
    data, h = mujoco.MjData(model), model.opt.timestep
    A, B = np.zeros((6, 6)), np.zeros((6, 1))
    data.qpos[:] = 0.3, -0.7, 1.1
    mujoco.mjd_transitionFD(model, data, 1e-6, True, A, B, None, None)
    system = from_mujoco(file).system
    graph = build_graph(system)
    ours = linearise(placed(system, np.array(data.qpos), np.zeros(graph.nv), {}), ["push"], at=0.0)
    assert ours.A[3:] == pytest.approx(((A - np.eye(6)) / h)[3:], abs=1e-4)
    assert ours.B[3:] == pytest.approx(B[3:] / h, abs=1e-4)


def test_joint_limits_of_imported_mujoco_models_are_as_stiff_as_in_mujoco(tmp_path):
    file = tmp_path / "limit.xml"
    file.write_text(
        f"""<mujoco>{G}{OFF}<worldbody><body><joint name="j" axis="0 1 0" range="-30 40" ref="10" limited="true"/>
<inertial pos="1 0 0" mass="2" diaginertia="1 1 1"/></body></worldbody></mujoco>"""
    )
    found = from_mujoco(file)
    (stop,) = found.system.stops
    assert (stop.lower, stop.upper) == pytest.approx((-40.0 * pi / 180.0, 30.0 * pi / 180.0))
    inertia = 1.0 + 2.0
    assert stop.k == pytest.approx(inertia / (0.95 * 0.02) ** 2, rel=1e-9)
    assert stop.d == pytest.approx(2.0 * inertia / (0.95 * 0.02), rel=1e-9)


LACKS = f"""<mujoco>{G}<worldbody><light/><geom type="plane" size="1 1 1"/>
<body name="a" gravcomp="1">
<joint name="h" armature="0.1" frictionloss="0.2"/><geom name="g" size="0.1" mass="1"/><site name="s"/></body>
<body name="b" pos="0 0 1"><joint name="w" type="ball" damping="1" range="0 30" limited="true"/><geom size="0.1"/>
<site name="u" pos="1 0 0"/></body><body name="m" mocap="true"/></worldbody>
<tendon><spatial name="over" stiffness="1"><site site="s"/><geom geom="g"/><site site="u"/></spatial>
<fixed name="sum" stiffness="2"><joint joint="h" coef="1"/></fixed>
<fixed name="idle"><joint joint="h" coef="1"/></fixed></tendon><sensor><jointpos joint="h"/></sensor>
<keyframe><key time="1"/></keyframe>
<equality><connect body1="a" body2="b" anchor="0 0 0"/></equality>
<actuator><general name="biceps" joint="h" dyntype="integrator"/>
<motor name="capped" joint="h" ctrlrange="-1 1" ctrllimited="true"/></actuator>
</mujoco>"""


def test_features_of_a_mujoco_model_that_cannot_be_imported_are_listed(tmp_path):
    file = tmp_path / "lacks.xml"
    file.write_text(LACKS)
    text = "\n".join(from_mujoco(file).missing)
    for sentence in (
        "joint 'h': armature", "joint 'h': dry friction", "joint 'w': springs", "joint 'w': limits", "tendon 'over': ",
        "tendon 'sum': ", "actuator 'biceps': ", "actuator 'capped': limits", "body 'a': compensation of gravity",
        "3 geoms that collide", "1 equality constraints", "1 bodies that are placed from outside", "1 sensors",
        "1 keyframes", "1 cameras and lights", "tendon 'idle': tendons without a spring",
    ):  # fmt: skip
        assert sentence in text


@pytest.mark.parametrize(
    ("text", "sentence"),
    [("<mujoco><worldbody>", "XML"), ("no model", "XML")],
)
def test_an_invalid_mujoco_file_is_refused_in_one_sentence(text, sentence, tmp_path):
    file = tmp_path / "bad.xml"
    file.write_text(text)
    with pytest.raises(SceneError) as error:
        from_mujoco(file)
    assert sentence in str(error.value)
    assert "\n" not in str(error.value)


def test_a_mujoco_file_that_is_too_large_or_missing_is_refused_in_one_sentence(tmp_path):
    file = tmp_path / "large.xml"
    with file.open("wb") as f:
        f.truncate(20_000_000)
    with pytest.raises(SceneError, match=r"large\.xml: 20 MB; a model has at most 16 MB"):
        from_mujoco(file)
    with pytest.raises(SceneError, match=r"none\.xml"):
        from_mujoco(tmp_path / "none.xml")
