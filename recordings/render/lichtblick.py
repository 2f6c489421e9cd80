"""A layout for Lichtblick and Foxglove, with what those programs need to show a recording at once: the scene in three
dimensions seen from the world, the rope tensions by name, the stages, the log.

It is attached to each recording; in the program: import the layout from the file, then open the recording.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, degrees, hypot
from typing import Any

import msgspec

__all__ = ["LAYOUT", "layout"]

LAYOUT = "lichtblick.json"
SCENE, TENSION, STAGES, LOG = "3D!scene", "Plot!tension", "StateTransitions!stages", "RosOut!log"
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#7a6fd0", "#6b7682")
VIEW = (-0.62, -0.72, 0.32)  # from where the scene is seen
FIELD = 45.0  # angle of view [degrees]


def layout(ropes: Sequence[str], middle: tuple[float, float, float], radius: float) -> bytes:
    """The layout as JSON: ropes in the order of the signal `rope/tension`, a ball around what is to be seen [m]."""
    panels = {SCENE: _scene(middle, radius), TENSION: _tension(ropes), STAGES: _stages(), LOG: _log()}
    below: dict[str, Any] = {"first": STAGES, "second": LOG, "direction": "column", "splitPercentage": 35}
    beside: dict[str, Any] = {"first": TENSION, "second": below, "direction": "column", "splitPercentage": 55}
    return msgspec.json.format(
        msgspec.json.encode(
            {
                "configById": panels,
                "globalVariables": {},
                "userNodes": {},
                "playbackConfig": {"speed": 20},
                "layout": {"first": SCENE, "second": beside, "direction": "row", "splitPercentage": 58},
            }
        )
    )


def _scene(middle: tuple[float, float, float], radius: float) -> dict[str, Any]:
    x, y, z = VIEW
    grid = {
        "layerId": "foxglove.Grid",
        "instanceId": "ground",
        "label": "ground",
        "visible": True,
        "size": 6 * radius,
        "divisions": 24,
        "lineWidth": 1,
        "color": "#9aa4ad66",
        "position": [middle[0], middle[1], 0],
        "rotation": [0, 0, 0],
        "order": 1,
    }
    return {
        "followMode": "follow-none",
        "followTf": "world",
        "fixedFrame": "world",
        "cameraState": {
            "perspective": True,
            "target": list(middle),
            "targetOffset": [0, 0, 0],
            "targetOrientation": [0, 0, 0, 1],
            "distance": 2.6 * radius,
            "phi": degrees(atan2(hypot(x, y), z)),
            "thetaOffset": degrees(atan2(y, x)) + 180.0,
            "fovy": FIELD,
            "near": radius / 200,
            "far": 60 * radius,
        },
        "scene": {"transforms": {"visible": False, "showLabel": False}, "enableStats": False},
        "topics": {"/scene": {"visible": True}, "/ropes": {"visible": True}},
        "layers": {"ground": grid},
        "transforms": {},
        "publish": {},
        "imageMode": {},
    }


def _tension(ropes: Sequence[str]) -> dict[str, Any]:
    paths = [
        {
            "value": f"/samples.rope_tension[{i}]",
            "label": f"{name} [N]",
            "enabled": True,
            "timestampMethod": "receiveTime",
            "color": COLOURS[i % len(COLOURS)],
        }
        for i, name in enumerate(ropes)
    ]
    return {
        "title": "rope tension",
        "paths": paths,
        "xAxisVal": "timestamp",
        "showXAxisLabels": True,
        "showYAxisLabels": True,
        "showLegend": True,
        "legendDisplay": "left",
        "showPlotValuesInLegend": True,
        "isSynced": True,
        "minYValue": 0,
        "sidebarDimension": 200,
    }


def _stages() -> dict[str, Any]:
    path = {"value": "/commander/stage.value.name", "label": "stage", "enabled": True, "timestampMethod": "receiveTime"}
    return {"paths": [path], "isSynced": True}


def _log() -> dict[str, Any]:
    return {"topicToRender": "/log", "searchTerms": [], "minLogLevel": 1}
