"""Impossible commands to a simulation, each with its error message."""

from dataclasses import replace
from math import inf, nan

from heavylift.kernel.description import (  # fmt: skip
    Body,
    Brake,
    Drive,
    Joint,
    Line,
    Master,
    Measured,
    Point,
    Rope,
    Threshold,
)
from small_scenes import SECOND, X, hung


def driven():
    scene = replace(
        hung(60.1, winch=True),
        bodies=(Body("load", 4.5e5), Body("b", 1.0), Body("c", 1.0)),
        joints=(
            *hung(60.1).joints,
            Joint("rail", "prismatic", "world", "b", axis=X),
            Joint("other", "prismatic", "world", "c", axis=X),
        ),
        drives=(Drive("drive", "rail", "prescribed"),),
        masters=(Master("theta"),),
        measured=(Measured("way", "joint", "other"), Measured("its", "joint", "other", followers=("servo",))),
        brakes=(Brake("brake", "other", 1.0, 1.0, 1.0),),
        thresholds=(Threshold("low", "joint", of="other"),),
    )
    return replace(scene, ropes=(*scene.ropes, Rope("sling", (Line(Point("world"), Point("b")),), 1e8, 5.0)))


COMMANDS = [
    (
        lambda s: s.references.set_profile("x", 0, 1.0, 1.0, None),
        "'x': there is no drive, winch or master with this name; there are theta, drive, rope, sling",
    ),
    (
        lambda s: s.references.set_profile("sling", 0, 1.0, 1.0, 1.0),
        "rope 'sling': it has no winch; declare one to change its length",
    ),
    (
        lambda s: s.references.set_profile("rope", SECOND, 1.0, 0.0, 1.0),
        "'rope' at 1.000 s: acceleration must be positive, not 0.0",
    ),
    (
        lambda s: s.references.set_profile("rope", 0, 1.0, inf, 1.0),
        "'rope' at 0.000 s: acceleration must be positive, not inf",
    ),
    (
        lambda s: s.references.set_profile("rope", 0, 0.0, 1.0, 1.0),
        "'rope' at 0.000 s: a distance cannot be travelled at speed 0; give a speed",
    ),
    (
        lambda s: s.references.set_profile("rope", 0, nan, 1.0, None),
        "'rope' at 0.000 s: speed nan and distance None must be finite numbers",
    ),
    (
        lambda s: s.references.set_profile("rope", 0, 1.0, 1.0, inf),
        "'rope' at 0.000 s: speed 1.0 and distance inf must be finite numbers",
    ),
    (
        lambda s: s.set_follow("sling", "theta", (1.0, 0.0, 0.0)),
        "rope 'sling': it has no winch; declare one to change its length",
    ),
    (
        lambda s: s.set_follow("rope", "x", (1.0, 0.0, 0.0)),
        "'rope' cannot follow 'x': masters are theta, way, its",
    ),
    (
        lambda s: s.set_follow("theta", "way", (1.0, 0.0, 0.0)),
        "'theta' cannot follow 'way': masters are theta, way, its",
    ),
    (
        lambda s: s.set_follow("rope", "its", (1.0, 0.0, 0.0)),
        "'rope' cannot follow 'its', which only servo may follow",
    ),
    (
        lambda s: s.set_follow("drive", "way", (1.0, 0.0, 0.0)),
        "'drive' cannot follow 'way': a prescribed drive can follow only a commanded master signal",
    ),
    (
        lambda s: s.set_follow("rope", "theta", (nan, 0.0, 0.0)),
        "'rope' cannot follow (nan, 0.0, 0.0): the coefficients must be finite numbers",
    ),
    (lambda s: s.set_brake("x", True), "'x': there is no brake with this name; there are brake"),
    (lambda s: s.switches.watch("x", 1.0, True), "'x': there is no threshold with this name; there are low"),
    (lambda s: s.switches.unwatch("x"), "'x': there is no threshold with this name; there are low"),
    (
        lambda s: s.switches.watch("low", nan, True),
        "threshold 'low': nan is not a valid threshold; it must be a finite number",
    ),
    (lambda s: s.unhook("x"), "'x': there is no rope with this name; there are rope, sling"),
    (lambda s: s.hook("x"), "'x': there is no rope with this name; there are rope, sling"),
    (lambda s: s.hook("sling", a=(1.0,)), "rope 'sling' at 0.000 s: end (1.0,); it must be 3 finite numbers"),
    (lambda s: s.hook("sling", b=(1.0, 2.0)), "rope 'sling' at 0.000 s: end (1.0, 2.0); it must be 3 finite numbers"),
    (
        lambda s: s.hook("sling", a=(nan,) * 3),
        "rope 'sling' at 0.000 s: end (nan, nan, nan); it must be 3 finite numbers",
    ),
    (lambda s: s.run(nan), "time nan: it must be a whole number of nanoseconds"),
    (lambda s: s.interrupt(1e8), "time 100000000.0: it must be a whole number of nanoseconds"),
    (lambda s: s.interrupt(-1), "time -1 ns is before the present time, 0 ns"),
    (lambda s: s.fire(), "no event has been located; call run() first"),
    (lambda s: s.hook("rope"), "rope 'rope' at 0.000 s: it is already hooked; unhook it first"),
]
