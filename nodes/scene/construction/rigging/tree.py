"""The rigging of a scene as a tree: positions of its frames at the start, and the parts that each entry adds to the
scene.

Frames are placed level above their load, so that their tightest sling has its specified slack and the slings that hold
a frame are stretched by the frame's weight. From there the scene is brought to equilibrium (see `building`). Slings
from one hook to lugs belong to the machine of the hook; every other entry is a machine of its own.
"""

from collections.abc import Callable, Container, Iterator
from math import sqrt

import numpy as np
from heavylift.kernel.algebra.dense import norm
from heavylift.kernel.algebra.elementary import atan2, cos, sin
from heavylift.kernel.description import mechanics as k
from heavylift.kernel.description.forces import InputSignal, Reeving, Sheave
from heavylift.nodes.plan.mechanism import Tie
from heavylift.nodes.scene.keys.base import BodyPoint
from heavylift.nodes.scene.keys.parts import joints, kinematics, mechanics
from heavylift.nodes.scene.keys.parts.rigging import Equaliser, Frame, Rigging, SlingKeys
from heavylift.nodes.scene.keys.schema import Scene
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Path, SourceText

from .edges import SPREAD, along_edges, equalising, height_of, lugs_of, rated, slings_of

NOWHERE = k.Point("")


class RiggingTree:
    """The rigging of a scene, with methods that check it; errors are added to the scene.

    `taken`: hooks from which frames of `rig` hang."""

    def __init__(self, source: SourceText, scene: Scene, around: k.System, taken: Container[str]) -> None:
        blocks = scene.all_blocks
        for name in () if blocks else scene.rigging:
            source.fault(("rigging", name), "there is no block to hold: add 'block'", on_key=True)
        self.source, self.scene, self.rigging, self.gravity = source, scene, scene.rigging, scene.gravity
        self.masses = {name: block.mass for name, block in blocks.items()}
        self.lugs = lugs_of(scene)
        self.coms = {body.name: body.com for body in around.bodies}
        parts = [*scene.machines.values(), *([scene.mechanism] if scene.mechanism else [])]
        self.taken = {*scene.machines, *(scene.rig.beams if scene.rig else ()), *scene.models}
        self.taken |= {*(body.name for body in around.bodies), *([scene.mechanism.name] if scene.mechanism else [])}
        self.hooks = {name: x for machine in parts for name, x in machine.hooks.items() if name not in taken}
        self.frames = {name: given for name, given in self.rigging.items() if isinstance(given, Frame)}
        self.ends = {h.replace(".", " ", 1): k.Point(h, (0.0, 0.0, -x.height)) for h, x in self.hooks.items()}
        self.points = {name: k.Point(name) for name in self.frames}
        for name, frame in self.frames.items():
            self.points |= {f"{name}.{at}": k.Point(name, p) for at, p in frame.points.items()}
        self._check()
        self.at = kinematics.poses(around) if self.rigging and not source.faults else {}
        for name in self.frames if not source.faults else ():
            self._place(name, ())

    # ---- names --------------------------------------------------------------------------------------------

    def upper(self, word: str) -> k.Point | None:
        """Return the upper attachment point of a sling by its name in the scene; None if the name is unknown."""
        words = " ".join(word.split())
        hook = words.replace(".", " ", 1) if words in self.hooks else words
        return self.ends.get(hook) or self.points.get(words)

    def lower(self, word: str) -> k.Point | None:
        """Return the lower attachment point of a sling by its name in the scene; None if the name is unknown."""
        return self.lugs.get(word) or self.points.get(word)

    def missing(self, word: str) -> tuple[str, str]:
        """Return the error for a name that matches nothing in the scene, with a hint at the nearest known name."""
        several = [lug for lug in self.lugs if lug.endswith(f".{word}")]
        if len(several) > 1:
            return f"several blocks have a lug '{word}'", f"write {' or '.join(several[:2])}"
        message = f"no block has a lug '{word}'" if self.scene.blocks else f"the block has no lug '{word}'"
        return message, closest(word, [*self.lugs, *self.points])

    def of_hook(self, hook: str) -> dict[str, SlingKeys]:
        """Return the rigging entries whose slings connect this hook with lugs, as parts of the hook's machine."""
        slings = {name: given for name, given in self.rigging.items() if isinstance(given, SlingKeys)}
        return {name: given for name, given in slings.items() if self._plain(given) == hook}

    def of_any(self, hook: str) -> bool:
        """Return whether any rigging entry hangs on a hook."""
        holders = (word for given in self.rigging.values() for word in getattr(given, "holders", ()))
        return any((point := self.upper(word)) is not None and point.body == hook for word in holders)

    def own(self) -> Iterator[tuple[Path, str]]:
        """Yield the rigging entries that become machines of their own, frames first."""
        for name, given in sorted(self.rigging.items(), key=lambda x: not isinstance(x[1], Frame)):
            if not self._plain(given):
                yield ("rigging", name), name

    def _plain(self, given: Rigging) -> str:
        """Return the hook if all slings of an entry lead from this one hook to lugs; "" for other entries."""
        if not isinstance(given, SlingKeys) or isinstance(given.on, list) or any(x not in self.lugs for x in given.to):
            return ""
        point = self.upper(given.on)
        return point.body if point and point.body in self.hooks else ""

    def _check(self) -> None:
        """Add errors for ends that do not exist, and for lugs and lower points with more than one sling."""
        beams = self.scene.rig.beams if self.scene.rig else {}
        used = {lug: beam for beam, given in beams.items() for lug in given.lugs or ()}
        for name, given in self.rigging.items():
            here: Path = ("rigging", name)
            if name in self.taken:
                self.source.fault(here, f"the name '{name}' is given twice: another machine has it, too", on_key=True)
            if isinstance(given, Frame):
                continue
            several = isinstance(given, SlingKeys) and isinstance(given.on, list)
            for i, word in enumerate(given.holders):
                at: Path = (*here, "on", i) if several else (*here, "on")
                if self.upper(word) is None:
                    what = "hook or frame" if self.frames else "hook"
                    self.source.fault(at, f"there is no {what} '{word}'", closest(word, [*self.ends, *self.points]))
                    break
            if isinstance(given, SlingKeys):
                for key, found in (("on", given.holders), ("length", given.lengths)):
                    if len(found) != len(given.to):
                        n = len(given.to)
                        message = f"{n} slings need {n} of them, or one for all, not {len(found)}"
                        self.source.fault((*here, key), message)
            for i, word in enumerate(given.to):
                if self.lower(word) is None:
                    self.source.fault((*here, "to", i), *self.missing(word))
                elif used.setdefault(word, name) != name or word in given.to[:i]:
                    what = "lug" if word in self.lugs else "point"
                    self.source.fault((*here, "to", i), f"the {what} {word} already carries a sling of {used[word]}")
        for name in self.frames:
            if not any(name == self._body(word) for x in self.rigging.values() for word in getattr(x, "to", ())):
                message = "nothing holds this frame: name it, or points of it, under the 'to' of slings"
                self.source.fault(("rigging", name), message, on_key=True)

    def _body(self, word: str) -> str:
        point = self.points.get(word)
        return point.body if point else ""

    # ---- places -------------------------------------------------------------------------------------------

    def _place(self, name: str, above: tuple[str, ...]) -> None:
        """Place a frame level above its load, with the same heading as the load."""
        if name in self.at or self.source.faults:
            return
        if name in above:
            self.source.fault(("rigging", name), f"'{name}' hangs below itself", on_key=True)
            return
        ends = [(p.p, word) for _, _, p, word in self._below(name)]
        for _, word in ends:
            if body := self._body(word):
                self._place(body, (*above, name))
        if self.source.faults:
            return
        if not ends:
            self.source.fault(("rigging", name), "this frame holds nothing: add slings that are 'on' it", on_key=True)
            return
        held = [self._where(word) for _, word in ends]
        n = len(ends)
        own = [[p[i] - sum(q[i] for q, _ in ends) / n for i in (0, 1)] for p, _ in ends]
        there = [[p[i] - sum(q[i] for q in held) / n for i in (0, 1)] for p in held]
        along = sum(a[0] * b[0] + a[1] * b[1] for a, b in zip(own, there, strict=True))
        across = sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(own, there, strict=True))
        yaw = float(atan2(across, along)) if abs(along) + abs(across) > SPREAD else 0.0
        c, s = float(cos(yaw)), float(sin(yaw))
        R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        mean = [sum(p[i] for p, _ in ends) / n for i in (0, 1)]
        x = sum(p[0] for p in held) / n - (c * mean[0] - s * mean[1])
        y = sum(p[1] for p in held) / n - (s * mean[0] + c * mean[1])
        self.at[name] = np.array([x, y, 0.0]), R
        z = self.height(name, lambda p: kinematics.place(p, self.at).tolist())
        if z is not None:
            self.at[name] = np.array([x, y, z]), R

    def _below(self, body: str) -> Iterator[tuple[str, int, k.Point, str]]:
        """Yield the slings and equalisers on a hook or frame, as (entry, number of the sling, upper point, lower
        attachment)."""
        for name, given in self.rigging.items():
            if isinstance(given, Frame):
                continue
            for i, word in enumerate(given.to):
                point = self.upper(given.holders[min(i, len(given.holders) - 1)])
                if point and point.body == body:
                    yield name, i, point, word

    def ropes(self, name: str) -> dict[str, tuple[int, k.Point, bool]]:
        """Return the ropes of a rigging entry by name: number of the sling, lower attachment point, and whether the
        rope is hooked at the start.

        Ropes to unknown lugs are omitted."""
        ends = {rope: (sling, self.lower(sling.holds)) for rope, sling in slings_of(self.scene, name).items()}
        return {rope: (sling.number, end, sling.hooked) for rope, (sling, end) in ends.items() if end is not None}

    def ties(self, name: str) -> list[Tie]:
        """Return the slings of a rigging entry, with their upper ends and lugs."""
        given, found = self.rigging[name], list[Tie]()
        words = {point: word for word, point in self.lugs.items()}  # the longer ones, where a lug has two
        for rope, sling in slings_of(self.scene, name).items():
            assert not isinstance(given, Frame)
            upper = self.upper(given.holders[sling.number])
            lower = self.lower(sling.holds)
            if upper is not None and lower is not None:
                lug = words.get(lower, "")
                held, most = lug if sling.hooked else "", rated(given.sling, self.gravity)
                where = self.source.where(("rigging", name))
                found.append(Tie(rope=rope, upper=upper, lug=held, lower=lower, rated=most, rigging=name, where=where))
        return found

    def carried(self, body: str) -> float:
        """Return the mass of the blocks suspended from a hook or frame at the start [kg]."""
        found, waiting = dict[str, float](), [body]
        while waiting:
            for _, _, _, word in self._below(waiting.pop()):
                point = self.lower(word)
                if point and point.body in self.masses:
                    found[point.body] = self.masses[point.body]
                elif point:
                    waiting.append(point.body)
        return sum(found.values())

    def _where(self, word: str) -> list[float]:
        """Return the position of a sling's lower attachment in the world frame [m]."""
        point = self.lower(word)
        assert point is not None
        x, y, z = kinematics.place(point, self.at).tolist()
        return [x, y, z]

    def height(self, body: str, at: Callable[[k.Point], list[float]]) -> float | None:
        """Return the height z [m] of a hook or frame at which its slings have their specified slack; None without
        slings.

        `at`: function that returns the world position [m] of a point of the hook or frame for z = 0."""
        found: list[float] = []
        for name, i, point, word in self._below(body):
            given, here = self.rigging[name], ("rigging", name, "to", i)
            p, q = at(point), self._where(word)
            assert not isinstance(given, Frame)
            if isinstance(given, Equaliser) or given.over_edges:
                found += [self._reeved(name, given, i, p)] if i == 0 or isinstance(given, SlingKeys) else []
                continue
            reach = given.lengths[i]
            if frame := self._body(word):
                held = [to for x in self.rigging.values() for to in getattr(x, "to", ()) if self._body(to) == frame]
                length = reach * (1.0 + self.frames[frame].mass * self.gravity / (len(held) * given.sling.EA))
            else:
                length = reach - given.slack
            lateral = norm([q[0] - p[0], q[1] - p[1]])
            if lateral >= length:
                what = f"the lug {word}" if word in self.lugs else word
                who = "the hook" if body in self.hooks else f"its end on {body}"
                message = f"{what} is {lateral:.3g} m beside {who}, too far for a sling of {reach:g} m"
                self.source.fault(here, message if self._body(word) else f"{message} with {given.slack:g} m of slack")
                continue
            found.append(q[2] + sqrt(length * length - lateral * lateral) - p[2])
        return min(found) if found else None

    def _reeved(self, name: str, given: SlingKeys | Equaliser, i: int, p: list[float]) -> float:
        """Return the height z [m] at which a rope over a sheave or edges has its specified slack; p: position of the
        sheave or upper end for z = 0 [m]."""
        words = given.to if isinstance(given, Equaliser) else [given.to[i]]
        length = given.length if isinstance(given, Equaliser) else given.lengths[i]
        ends = [end for word in words if (end := self.lower(word)) is not None]

        def rope(z: float) -> Reeving:
            at = k.Point(k.WORLD, (p[0], p[1], p[2] + z))
            if isinstance(given, Equaliser):
                return equalising(name, given, at, np.eye(3), (ends[0], ends[1]), self.at)
            return Reeving(name, at, self.edges(name, i), ends[0], given.sling.EA, InputSignal(length))

        radius = given.radius if isinstance(given, Equaliser) else 0.0
        low = max(self._where(word)[2] for word in words) + radius - p[2] + SPREAD
        try:
            what = "over the sheave" if isinstance(given, Equaliser) else "over its edges"
            return height_of(rope, low, length, given.slack, self.at, what)
        except ValueError as error:
            self.source.fault(("rigging", name, "length"), str(error), on_key=True)
        return low

    def edges(self, name: str, i: int) -> tuple[Sheave, ...]:
        """Return the edges over which the i-th sling of a rigging entry may bend."""
        given = self.rigging[name]
        assert isinstance(given, SlingKeys)
        ends = self.upper(given.holders[i]) or NOWHERE, self.lower(given.to[i]) or NOWHERE
        return along_edges(
            self.source, ("rigging", name), given.over_edges, self.scene.edges, ends, self.coms, lambda: self.at
        )

    def made(self, name: str, around: k.System) -> mechanics.MechanismKeys:
        """Return a rigging entry converted to the keys of a machine that joins the mechanical system `around`."""
        given, make = self.rigging[name], mechanics.MechanismKeys.model_construct
        if isinstance(given, Frame):
            p, R = self.at[name]
            half = 0.5 * float(atan2(float(R[1][0]), float(R[0][0])))
            attitude = (0.0, 0.0, float(sin(half)), float(cos(half)))
            free = joints.Free.model_construct(type="free", child=name, position=tuple(p.tolist()), attitude=attitude)
            body = mechanics.BodyKeys.model_construct(mass=given.mass, com=given.com, box=given.size)
            return make(name=name, bodies={name: body}, joints={f"{name}.free": free})
        ropes, at = dict[str, mechanics.RopeKeys](), kinematics.poses(around)
        for rope, (i, lower, hooked) in self.ropes(name).items():
            upper = self.upper(given.holders[i])
            assert upper is not None
            start, end, over = _end(upper), _end(lower), list[mechanics.Over]()
            length = given.length if isinstance(given, Equaliser) else given.lengths[i]
            if isinstance(given, Equaliser):
                ends = lower, self.lower(given.to[1]) or lower
                made = equalising(name, given, upper, at[upper.body][1], ends, self.at).sheaves[0]
                over = [
                    mechanics.Over.model_construct(
                        body=upper.body, at=upper.p, axis=made.axis, radius=made.radius, friction=made.friction,
                        efficiency=made.efficiency,
                    )
                ]  # fmt: skip
                start, end = end, _end(ends[1])
            light = self.hooks[upper.body].block if upper.body in self.hooks else self.frames[upper.body].mass
            damping = 2.0 * given.sling.damping * sqrt(given.sling.EA / length * light)
            edges = [] if isinstance(given, Equaliser) or not hooked else given.over_edges
            ropes[rope] = mechanics.RopeKeys.model_construct(
                start=start, end=end, over=over, over_edges=edges, EA=given.sling.EA, length=length, damping=damping,
                hooked=hooked,
            )  # fmt: skip
        return make(name=name, ropes=ropes)


def _end(point: k.Point) -> BodyPoint:
    return BodyPoint.model_construct(body=point.body, at=point.p)
