"""A second recording in the page of a first one, at the same times: bodies as glass, signals as dashed curves."""

from __future__ import annotations

from typing import NamedTuple

import msgspec
import numpy as np
from heavylift.recordings.format.samples import POSE
from heavylift.recordings.format.viewer_messages import Box
from heavylift.recordings.read.reader import Recording
from numpy.typing import NDArray

from .content import Shown

Floats = NDArray[np.float64]
BESIDE = "beside/"  # before the group of a signal
GLASS = 0.25  # opacity


class Ghost(NamedTuple):
    """Names of bodies and their shapes; (group, name, unit) of signals; poses (n, 7 bodies), values (n, signals)."""

    bodies: list[str]
    boxes: list[Box]
    signals: list[tuple[str, str, str]]
    poses: Floats
    values: Floats


def ghost(rec: Recording, like: Shown, t: Floats) -> Ghost:
    """What a recording has of the bodies and signals of another one at its times (n,) [s]; where it has ended bodies
    stay where they were, and signals are not a number."""
    known, drawn = rec.signals(), rec.boxes()
    bodies = [b for b in like.bodies if POSE + b in known and any(box.body == b for box in drawn)]
    signals = [s for s in like.signals if s[0] in known and s[1] in rec.columns(s[0])]
    rec.load([*(POSE + b for b in bodies), *dict.fromkeys(group for group, _, _ in signals)])
    poses, values = [np.zeros((len(t), 0))], [np.zeros((len(t), 0))]
    for body in bodies:
        pose = rec.signal(POSE + body)
        x = pose.at(np.clip(t, pose.t[0], pose.t[-1])).values.copy()
        x[:, 3:] /= np.linalg.norm(x[:, 3:], axis=1, keepdims=True)
        poses.append(x)
    at = {group: rec.signal(group).at(t) for group, _, _ in signals}
    values += [at[group][name][:, None] for group, name, _ in signals]
    names = {body: f"{body} {rec.path.name}" for body in bodies}
    boxes = [
        msgspec.structs.replace(box, body=names[box.body], colour=(*box.colour[:3], GLASS))
        for box in drawn
        if box.body in names
    ]
    beside = [(BESIDE + group, name, unit) for group, name, unit in signals]
    return Ghost(list(names.values()), boxes, beside, np.hstack(poses), np.hstack(values))
