"""How near things come to the ground, which is the plane z = 0: their lowest points, with a bound between samples.

A block that stands, is lifted off or is set down comes near the ground on purpose: until it is carried aside of where
it stands, and while it is ordered to land, it must only not go into the ground.  A hook that carries nothing may come
as low as it likes above it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from heavylift.nodes.limits.shapes import Kind, Solid, Strand
from heavylift.nodes.scene.plan import Plan
from numpy.typing import NDArray

from .history import History
from .moving import Moving, chords

__all__ = ["TOUCH", "Low", "over_ground"]

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Spans = Sequence[tuple[float, float]]
ABOVE: tuple[Kind, ...] = ("block", "loader", "sling", "trolley")
PARTS = ("girder", "cross beam")  # of a portal, which stands on the ground with the others
TOUCH = 0.01  # depth of a penetration that is only numbers, such as of a pad that yields [m]
CONTACT = 1e-3  # between a pad and its stool that is none [m]
ASIDE = 1.0  # from where a block stands: as far as it and its trolleys go, it is lifted off or set down [m]


@dataclass(frozen=True)
class Low:
    """The lowest point of a thing: its distance from the ground [m], when [s], its place (3,); the limit to keep [m],
    0 where it must only not go into the ground."""

    shape: Moving
    distance: float
    t: float
    p: Floats
    limit: float


@dataclass(frozen=True)
class _Gap:
    """Of one shape: the gap at each sample (n,) and the least one from each sample to the next (n - 1,) [m]."""

    shape: Moving
    at: Floats
    after: Floats

    @property
    def about(self) -> Floats:
        """(n,) the least gap about each sample."""
        found = self.at.copy()
        np.minimum(found[1:], self.after, out=found[1:])
        np.minimum(found[:-1], self.after, out=found[:-1])
        return found


def over_ground(plan: Plan, shapes: Sequence[Moving], history: History, limit: float, landing: Spans) -> list[Low]:
    """The nearest of each thing; `landing`: from when to when [s] orders to land are carried out."""
    if not plan.cranes:
        return []
    things: dict[str, list[_Gap]] = {}
    for s in shapes:
        if s.shape.kind in ABOVE or (isinstance(s.shape, Solid) and s.shape.part in PARTS):
            things.setdefault(s.shape.thing, []).append(_gap(s))
    stands, sinks = _stands(plan, history)
    block = next((gaps for gaps in things.values() if gaps[0].shape.shape.kind == "block"), [])
    near = block[0].about < limit if block else np.zeros(len(history.t), bool)
    meant = _meant(plan, history, near, stands, landing)
    found = []
    for gaps in things.values():
        shape = gaps[0].shape.shape
        free = ~np.zeros(len(history.t), bool)
        if shape.kind in ("block", "sling"):
            free = ~meant
        elif shape.kind == "loader":
            free = _loaded(plan, history, shape.thing)
        through = _least(gaps, ~np.zeros(len(history.t), bool), 0.0, sinks if shape.kind == "block" else None)
        kept = _least(gaps, free, limit)
        found += [x for x in ((through if through and through.distance < -TOUCH else kept),) if x is not None]
    return found


def _gap(s: Moving) -> _Gap:
    """Of a shape that goes straight from sample to sample, but for what it strays and, as it turns, w^2 r / 8."""
    at = s.centre[:, 2] - s.radius
    if isinstance(s.shape, Strand):
        at -= np.abs(s.turn[:, 2]) / 2
    else:
        up = _up(s.turn)
        for half, own in zip(s.half.tolist(), zip(*s.shape.R, strict=True), strict=True):
            along = sum((x * r for x, r in zip(own, up, strict=True) if x), np.zeros(1))
            at -= half * np.abs(along)
    after = np.minimum(at[1:], at[:-1]) - s.stray
    if len(s.turn) > 1 and isinstance(s.shape, Solid):
        angle = 2.0 * np.arcsin(np.minimum(1.0, chords(s.turn[1:], s.turn[:-1]) / 2))
        after -= angle * angle * s.reach / 8.0
    return _Gap(s, at, after)


def _up(turn: Floats) -> tuple[Floats, Floats, Floats]:
    """The third row of the rotations of quaternions (n, 4)."""
    x, y, z, w = turn.T
    return 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)


def _least(gaps: Sequence[_Gap], free: Flags, limit: float, sinks: Floats | None = None) -> Low | None:
    """The least of a thing's shapes at and between samples that are free; `sinks` (n,): by how much its pads yield."""
    best: Low | None = None
    for gap in gaps:
        there = free if gap.shape.there is None else free & gap.shape.there
        at = np.where(there, gap.at if sinks is None else gap.at + sinks, np.inf)
        after = np.where(there[1:] & there[:-1], gap.after if sinks is None else gap.after + sinks[1:], np.inf)
        k, j = int(np.argmin(at)), int(np.argmin(after)) if len(after) else 0
        value = min(float(at[k]), float(after[j]) if len(after) else np.inf)
        if np.isfinite(value) and (best is None or value < best.distance):
            if at[k] > value:
                k = j if gap.at[j] <= gap.at[j + 1] else j + 1
            best = Low(gap.shape, value, float(gap.shape.t[k]), _lowest(gap.shape, k), limit)
    return best


def _lowest(s: Moving, k: int) -> Floats:
    """(3,) the middle of what of a shape is lowest at a sample."""
    R, half = (x[0] for x in s.axes(np.array([k])))
    down = np.where(np.abs(R[2]) > 1e-6, -np.sign(R[2]), 0.0)
    point: Floats = s.centre[k] + R @ (down * half)
    point[2] -= s.radius
    return point


def _stands(plan: Plan, history: History) -> tuple[Flags, Floats]:
    """(n,) when the block stands on a pad, and by how much its pads yield at most [m]."""
    n = len(history.t)
    depth = np.zeros(n)
    pose = history.poses.get(plan.block.name) if plan.block else None
    if plan.block is None or pose is None:
        return np.zeros(n, bool), depth
    row = _up(pose[:, 3:])
    deepest = np.full(n, -np.inf)
    for pad in plan.block.pads:
        height = pose[:, 2] + sum(p * r for p, r in zip(pad.support.point.p, row, strict=True))
        np.maximum(deepest, pad.support.height - height, out=deepest)
    return deepest >= -CONTACT, np.maximum(depth, deepest)


def _meant(plan: Plan, history: History, near: Flags, stands: Flags, landing: Spans) -> Flags:
    """(n,) when the block is near the ground on purpose: it stands, or near the ground it is about to, or just did."""
    anchors = stands.copy()
    for first, last in landing:
        anchors |= near & (history.t >= first) & (history.t <= last)
    found = anchors.copy()
    if plan.block is None or not found.any():
        return found
    block, trolleys = history.poses[plan.block.name][:, :2], _trolleys(plan, history)
    for first, last in _runs(near | stands):
        at = np.flatnonzero(anchors[first:last]) + first
        if len(at):
            k = np.arange(first, last)
            i = np.searchsorted(at, k)
            for other in (at[np.minimum(i, len(at) - 1)], at[np.maximum(i - 1, 0)]):
                carried = [np.hypot(*(x[k] - x[other]).T) > ASIDE for x in (block, trolleys)]
                found[k] |= ~(carried[0] & carried[1])
    return found


def _trolleys(plan: Plan, history: History) -> Floats:
    """(n, 2) the middle of the trolleys, which does not swing."""
    names = sorted({line.a.body for rope in plan.rig.hook_ropes for line in rope.lines} & set(history.poses))
    found = np.zeros((len(history.t), 2))
    for name in names:
        found += history.poses[name][:, :2] / len(names)
    return found


def _runs(flags: Flags) -> Iterator[tuple[int, int]]:
    """From where to where (exclusive) flags are set without a gap."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    yield from zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)


def _loaded(plan: Plan, history: History, loader: str) -> Flags:
    """(n,) when a sling of a loader is taut."""
    found = np.zeros(len(history.t), bool)
    for sling in plan.rig.slings:
        if sling.loader == loader and sling.name in history.tensions:
            found |= history.tensions[sling.name] > 0.0
    return found
