"""Feet share a load by its centre of mass, as in statics and in MuJoCo."""

import numpy as np
import pytest
from contact_scenes import on_three_feet  # fmt: skip
from small_scenes import SECOND, G, column, started

FINE = {"tolerance": 1e-10}


def test_three_feet_share_the_weight_of_a_plate_by_the_position_of_its_centre_of_mass():
    """Moments about the feet: c carries (y + 1) / 3, a and b share the rest about x."""
    x, y = 0.3, 0.2
    s = started(on_three_feet(x, y), **FINE)
    s.run(SECOND)
    c = (y + 1.0) / 3.0
    shares = [(1.0 - c - x) / 2.0, (1.0 - c + x) / 2.0, c]
    assert column(s, "contact/force")[1][-1] == pytest.approx(np.array(shares) * 6.0 * G, rel=1e-9)


def test_feet_of_a_plate_carry_the_loads_computed_by_mujoco():
    """Its contacts give way a little: the plate leans by 0.1 mm and settles."""
    import mujoco

    feet = "".join(f'<geom type="sphere" size="0.05" pos="{p} 0"/>' for p in ("-1 -1", "1 -1", "0 2"))
    plate = '<inertial pos="0.3 0.2 0.3" mass="6" diaginertia="1 1 1"/>'
    body = f'<body pos="0 0 0.05"><freejoint/>{plate}{feet}</body>'
    world = f'<worldbody><geom type="plane" size="9 9 1"/>{body}</worldbody>'
    model = mujoco.MjModel.from_xml_string(f'<mujoco><option gravity="0 0 -{G}" timestep="0.001"/>{world}</mujoco>')
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 3000)
    force, theirs = np.zeros(6), {}
    for i in range(data.ncon):
        mujoco.mj_contactForce(model, data, i, force)
        theirs[int(data.contact[i].geom[1])] = float(force[0])
    s = started(on_three_feet(0.3, 0.2), **FINE)
    assert column(s, "contact/force")[1][-1] == pytest.approx([theirs[i] for i in (1, 2, 3)], rel=1e-3)
