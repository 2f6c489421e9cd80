"""Public MJCF models: accelerations and tendon lengths agree with MuJoCo except for listed features.

Models come with gymnasium-robotics; those of dm-control and myo-sim (`pip install --no-deps dm-control myo-sim`, whose
bounds on MuJoCo would hold here, too) are compared if they are installed.
"""

import re
from importlib.util import find_spec
from pathlib import Path

import mujoco
import numpy as np
import pytest
from heavylift import from_mujoco
from heavylift.kernel.forces.reeving import ReevingLaw
from mujoco_peer import BODY, TENDON, compared, names_of, switched_off

PACKAGES = "gymnasium_robotics", "dm_control", "myo_sim"
WHOLE = re.compile("<mujoco[ >]")  # a model, not a part of one
EXACT = 1e-9  # of accelerations relative to the largest: rounding of ill-conditioned mass matrices; of lengths
SHORT = 0.3  # length of a rope's spring relative to the tendon: taut in each pose
STATES, POSES = 2, 20


def files() -> list[str]:
    """The XML files of the packages, relative to the folder of packages."""
    found = []
    for package in PACKAGES:
        if (spec := find_spec(package)) and spec.origin:
            folder = Path(spec.origin).parent
            whole = (
                file for file in sorted(folder.rglob("*.xml")) if re.search("<mujoco[ >]", file.read_text("utf-8"))
            )
            found += [str(file.relative_to(folder.parent)) for file in whole]
    return found


def model_of(file: str) -> mujoco.MjModel:
    """The model of a file; parts of models that MuJoCo does not load, and models that do not move, are passed over."""
    spec = find_spec(file.split("/")[0])
    assert spec
    assert spec.origin
    try:
        model = mujoco.MjModel.from_xml_path(str(Path(spec.origin).parents[1] / file))
    except ValueError:
        pytest.skip("this file is part of a model")
    if not model.nv:
        pytest.skip("this model does not move")
    return model


@pytest.mark.large(beyond=20)
@pytest.mark.parametrize("file", files())
def test_a_public_mujoco_model_keeps_its_accelerations_except_for_features_listed_as_not_imported(file):
    model = model_of(file)
    system, _, missing = from_mujoco(model)
    data, r = mujoco.MjData(model), np.random.default_rng(model.nv)
    switched_off(model, data, missing)
    for _ in range(STATES):
        ours, want = compared(system, model, data, r)
        assert len(want) == model.nv
        assert ours == pytest.approx(want, abs=EXACT * (1.0 + np.abs(want).max()))


@pytest.mark.parametrize("file", [file for file in files() if "myo_sim" in file or "cup" in file or "coupled" in file])
def test_ropes_imported_from_public_mujoco_models_have_the_lengths_of_the_tendons_in_all_poses(file):
    """Each tendon gets a spring, so that it becomes a rope if it has an equal."""
    model = model_of(file)
    if not model.ntendon:
        pytest.skip("this model has no tendons")
    data, r = mujoco.MjData(model), np.random.default_rng(model.nv)
    mujoco.mj_forward(model, data)
    model.tendon_stiffness[:], model.tendon_damping[:], model.tendon_lengthspring[:, 0] = 100.0, 0.0, 0.0
    model.tendon_lengthspring[:, 1] = SHORT * np.abs(data.ten_length)
    system, _, missing = from_mujoco(model)
    bodies, tendons = names_of(model, BODY, model.nbody), names_of(model, TENDON, model.ntendon)
    lost = {x.split("'")[1] for x in missing if "over joints or in space" in x}
    ropes = {rope.name: rope for rope in (*system.ropes, *system.reevings)}
    assert {*ropes} | lost == {*tendons}
    ranges = np.where(model.jnt_limited[:, None], model.jnt_range, (-1.0, 1.0))

    def pose(body):
        i = bodies.index(body)
        return data.xmat[i].reshape(3, 3), data.xpos[i]

    def at(point):
        R, p = pose(point.body)
        return p + R @ point.p

    for _ in range(POSES):
        for j in np.flatnonzero(model.jnt_type >= int(mujoco.mjtJoint.mjJNT_SLIDE)):
            data.qpos[model.jnt_qposadr[j]] = r.uniform(*ranges[j])
        mujoco.mj_forward(model, data)
        for name, rope in ropes.items():
            straight = sum(
                line.share * np.linalg.norm(at(line.a) - at(line.b)) for line in rope.lines if not over(rope)
            )
            length = ReevingLaw().start_length(rope, pose) if over(rope) else straight
            assert length == pytest.approx(data.ten_length[tendons.index(name)], rel=EXACT)


def over(rope) -> bool:
    return hasattr(rope, "sheaves")
