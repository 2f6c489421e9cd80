"""A layout for Lichtblick and Foxglove, with what those programs need to show a recording at once: the scene in three
dimensions seen from the world, the rope tensions by name, the stages, the log.

It is attached to each recording; in the program: import the layout from the file, then open the recording.  What is
the same in all of them stands in `page/lichtblick.json`.
"""

from collections.abc import Sequence
from math import atan2, degrees, hypot
from pathlib import Path
from typing import Any

import msgspec

LAYOUT = "lichtblick.json"
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#7a6fd0", "#6b7682")
VIEW = (-0.62, -0.72, 0.32)  # from where the scene is seen


def layout(ropes: Sequence[str], middle: tuple[float, float, float], radius: float) -> bytes:
    """The layout as JSON: ropes in the order of `rope/tension`, a bounding sphere of the view [m]."""
    whole = msgspec.json.decode((Path(__file__).parents[1] / "page" / LAYOUT).read_bytes())
    panels: dict[str, Any] = whole["configById"]
    x, y, z = VIEW
    panels["3D!scene"]["cameraState"] |= {
        "target": list(middle),
        "distance": 2.6 * radius,
        "phi": degrees(atan2(hypot(x, y), z)),
        "thetaOffset": degrees(atan2(y, x)) + 180.0,
        "near": radius / 200,
        "far": 60 * radius,
    }
    panels["3D!scene"]["layers"]["ground"] |= {"size": 6 * radius, "position": [middle[0], middle[1], 0]}
    panels["Plot!tension"]["paths"] = [
        {
            "value": f"/samples.rope_tension[{i}]",
            "label": f"{name} [N]",
            "enabled": True,
            "timestampMethod": "receiveTime",
            "color": COLOURS[i % len(COLOURS)],
        }
        for i, name in enumerate(ropes)
    ]
    return msgspec.json.format(msgspec.json.encode(whole))
