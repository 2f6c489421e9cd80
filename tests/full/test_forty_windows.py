"""IFToMM A02 with N = 40: 81 rods, 200 rows, of which 80 are independent except where all rods lie in one line.

The code takes half a minute to compile; the motion of 20 s passes thirty such poses.
"""

import json
import sys
from math import cos, sin
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parents[1] / "kernel"))

from linkages import windows
from small_scenes import SECOND, hand_over, started

FOLLOWS = 1e-6  # at tolerance 1e-10, as with N = 2


def test_a_chain_of_40_linkages_with_four_bars_each_moves_exactly_through_singular_poses():
    data = Path(__file__).parents[1] / "data" / "linkages.json"
    s = started(windows(40), tolerance=1e-10, sample_ns=SECOND)
    foot = s.program.graph.joint("foot0").q.start
    for t, (x, z) in json.loads(data.read_text())["A02 N=40"].items():
        hand_over(s, int(t) * SECOND)
        angle = s.state[foot]
        assert [sin(angle), cos(angle)] == pytest.approx([x, z], rel=0.0, abs=FOLLOWS)
        s.settle()
