"""Reference values of actuators: speed profiles that start at integer times, and functions of a master signal,
continuous across commands.

The simulation holds each actuator's present profile with its start time in integer nanoseconds; the machine code gets
starts relative to the last event, so that no precision is lost in long runs. P holds only the active piece of a
signal's history, so that a long history costs no more than a short one; breakpoints are step boundaries: the simulation
ends a step there, commits it and loads the next piece, so that the integrators keep their order.
"""

from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass
from math import inf, isfinite

import numpy as np
from heavylift.kernel.algebra.elementary import cos, sin
from heavylift.kernel.description.forces import InputSignal
from heavylift.kernel.description.mechanics import System
from heavylift.kernel.description.profile import REST, Trapezoid, trapezoid
from heavylift.kernel.errors import KernelError
from heavylift.kernel.forces.table import signals

from .parameters import ParameterLayout, irregular_waves
from .wave_pieces import WavePieces

AT_REST = 1e-12  # [m/s] a speed left over by round-off
SAME = 1e-9  # relative difference of two values that is round-off


@dataclass
class ReferenceProfile:
    """Reference of an actuator: a speed profile from the value x0, and coefficients of followed master signals."""

    start_ns: int
    x0: float
    move: Trapezoid
    follows: dict[int, tuple[float, float, float]]


class References:
    """Speed profiles and followed master signals of all drives and winches, written into the parameter block P."""

    def __init__(self, parameters: ParameterLayout, P: np.ndarray, system: System) -> None:
        self._at, self._P = parameters.at, P
        self._masters = [m.name for m in system.masters] + [m.name for m in system.measured]
        self._commanded = {m.name for m in system.masters}
        self._followers = {m.name: m.followers for m in system.measured if m.followers}
        drives = {d.joint: d.name for d in system.drives}
        self._asked = [m.name for m in system.masters] + [drives.get(m.of, m.name) for m in system.measured]
        self._still = {r.name for r in system.straight_ropes if not r.winch}
        self._placed = {d.name for d in system.drives if d.kind == "prescribed"}  # before anything is measured
        names = [name for kind, name in parameters.at if kind == "reference"]
        places = np.arange(len(P))
        self._references = np.array([places[parameters.at["reference", n]] for n in names], int).ravel()
        follows = [places[where] for (kind, _), where in parameters.at.items() if kind == "follow"]
        self._follows = np.concatenate([*follows, places[:0]])
        given = signals(system.forces)
        self.histories = Histories(given, parameters, P)
        self.waves = WavePieces(irregular_waves(system), parameters.at, P)
        waves = [*(d.wave for d in system.drives), *(s.wave for s in given.values())]
        self._ramps = {round(wave.ramp * 1e9) for wave in waves if wave}
        self.admit: Callable[[str], None] = lambda command: None  # called before each command
        self._epoch_ns = 0
        self.actuators = {n: ReferenceProfile(0, float(P[self._at["reference", n]][1]), REST, {}) for n in names}

    def _actuator(self, name: str) -> ReferenceProfile:
        if name not in self.actuators:
            raise KernelError(
                f"'{name}': there is no drive, winch or master with this name; there are {', '.join(self.actuators)}"
            )
        return self.actuators[name]

    def _driven(self, name: str) -> ReferenceProfile:
        a = self._actuator(name)
        if name in self._still:
            raise KernelError(f"rope '{name}': it has no winch; declare one to change its length")
        return a

    def own(self, name: str, t_ns: int) -> tuple[float, float]:
        """Return value and speed of an actuator's own speed profile at a time, without the followed master signals."""
        a = self._actuator(name)
        if a.move is REST:
            return a.x0, 0.0
        t = (t_ns - a.start_ns) * 1e-9
        speed = a.move.speed(t)
        return a.x0 + a.move.displacement(t), 0.0 if abs(speed) < AT_REST else speed

    def stand(self, epoch_ns: int) -> None:
        """Set the present time [ns], at which the next commands take effect."""
        self._epoch_ns = epoch_ns

    def value(self, name: str, t_ns: int) -> float:
        """Return an actuator's reference at a time: its own profile plus functions of followed master signals.

        A measured joint counts with the reference of its drive.
        """
        led = [_follow(k, self.own(self._asked[m], t_ns)[0]) for m, k in self._actuator(name).follows.items()]
        return self.own(name, t_ns)[0] + sum(led)

    def speed(self, name: str, t_ns: int) -> float:
        """Return the rate of an actuator's reference at a time."""
        own = self.own(name, t_ns)[1]
        for m, (k1, kc, ks) in self._actuator(name).follows.items():
            s, ds = self.own(self._asked[m], t_ns)
            own += float(k1 - kc * sin(s) + ks * cos(s)) * ds
        return own

    def set_profile(self, name: str, start_ns: int, speed: float, accel: float, distance: float | None) -> None:
        """Start a trapezoid speed profile of an actuator from its present value and speed; raises KernelError if the
        profile is impossible."""
        a = self._driven(name)
        self._check_start(name, start_ns)
        x0, v0 = self.own(name, start_ns)
        try:
            move = trapezoid(distance, speed, accel, v0)
        except ValueError as e:
            raise KernelError(f"'{name}' at {start_ns * 1e-9:.3f} s: {e}") from e
        self.admit("set_profile")
        a.start_ns, a.x0, a.move = start_ns, x0, move

    def _check_start(self, name: str, start_ns: int) -> None:
        """Raise KernelError for a start in the past, or in the future of an actuator that moves until then."""
        now = self._epoch_ns
        if not isinstance(start_ns, int | np.integer):
            raise KernelError(f"'{name}': start {start_ns!r}; it must be a whole number of nanoseconds")
        if start_ns < now:
            advice = "start the profile there or later"
        elif start_ns > now and self._moves(name, now, start_ns):
            advice = "it moves until then; start the profile there"
        else:
            return
        raise KernelError(
            f"'{name}' at {start_ns * 1e-9:.9g} s: the simulation has reached {now * 1e-9:.9g} s; {advice}"
        )

    def _moves(self, name: str, now_ns: int, until_ns: int) -> bool:
        (x, v), (later, speed) = self.own(name, now_ns), self.own(name, until_ns)
        return v != 0.0 or speed != 0.0 or abs(later - x) > SAME * (1.0 + abs(x))

    def moves(self, name: str, t_ns: int) -> bool:
        """Return whether an actuator moves by itself, or follows a master signal that moves."""
        a = self._actuator(name)
        masters = [self._masters[m] for m in a.follows]
        return self.own(name, t_ns)[1] != 0.0 or any(m in self.actuators and self.moves(m, t_ns) for m in masters)

    def set_value(self, name: str, t_ns: int, value: float) -> None:
        """Set an actuator's reference to a constant at once, such as the new length of a sling being hooked."""
        a = self._actuator(name)
        self.admit("set_value")
        a.start_ns, a.x0, a.move, a.follows = t_ns, value, REST, {}

    def set_follow(self, name: str, t_ns: int, master: str, f: tuple[float, float, float], now: list[float]) -> None:
        """Make an actuator follow k1 s + kc cos s + ks sin s without a jump, where s is the value of a master signal.

        "": no master signal. `now`: present values of the master signals.
        """
        a = self._driven(name)
        if master and (master not in self._masters or name in self._masters):
            raise KernelError(f"'{name}' cannot follow '{master}': masters are {', '.join(self._masters) or 'none'}")
        if master and name in self._placed and master not in self._commanded:
            raise KernelError(
                f"'{name}' cannot follow '{master}': a prescribed drive can follow only a commanded master signal"
            )
        if name not in self._followers.get(master, (name,)):
            raise KernelError(
                f"'{name}' cannot follow '{master}', which only {', '.join(self._followers[master])} may follow"
            )
        if not all(map(isfinite, f)):
            raise KernelError(f"'{name}' cannot follow {f}: the coefficients must be finite numbers")
        self.admit("set_follow")
        before = sum(_follow(k, now[m]) for m, k in a.follows.items())
        a.follows = {self._masters.index(master): f} if master else {}
        after = sum(_follow(k, now[m]) for m, k in a.follows.items())
        a.x0 += before - after

    def take(self, other: "References") -> None:
        """Copy the present motions of actuators with equal names from the references of another scene."""
        for name in self.actuators.keys() & other.actuators.keys():
            a = other.actuators[name]
            follows = {self._masters.index(other._masters[m]): f for m, f in a.follows.items()}
            self.actuators[name] = ReferenceProfile(a.start_ns, a.x0, a.move, follows)

    def stop(self, t_ns: int) -> None:
        """Stop the profiles of all actuators; actuators that follow a master signal keep following it."""
        for name, a in self.actuators.items():
            a.start_ns, a.x0, a.move = t_ns, self.own(name, t_ns)[0], REST

    def write(self, epoch_ns: int) -> None:
        """Write profiles, followed master signals and histories of all actuators into P; times [s] since the epoch."""
        self._epoch_ns = epoch_ns
        rows = list[float]()
        for a in self.actuators.values():
            m, start = a.move, (a.start_ns - epoch_ns) * 1e-9
            rows += start, a.x0, m.v0, m.a1, m.d1, m.cruise if m.cruise < inf else 1e12, m.a2, m.d2
        self._P[self._references] = rows
        self._P[self._follows] = 0.0
        for name, a in self.actuators.items():
            for i, k in a.follows.items():
                self._P[self._at["follow", name]][3 * i : 3 * i + 3] = k
        self.histories.write(epoch_ns)
        self.waves.write(epoch_ns)
        if ("clock", "") in self._at:
            self._P[self._at["clock", ""]] = epoch_ns * 1e-9

    def breaks(self, epoch_ns: int, after: float = 0.0) -> list[float]:
        """Return the sorted times after `after` [s since the epoch] at which reference accelerations or slopes jump."""
        out = {*self.histories.breaks(epoch_ns, after), *self.waves.breaks(epoch_ns, after)}
        out |= {t for end in self._ramps if (t := (end - epoch_ns) * 1e-9) > after}
        for a in self.actuators.values():
            if a.move is REST and a.start_ns <= epoch_ns:
                continue
            t = (a.start_ns - epoch_ns) * 1e-9
            for d in (a.move.d1, a.move.cruise, a.move.d2):
                t += d
                if after < t < inf:
                    out.add(t)
        return sorted(out)

    def rest(self, epoch_ns: int) -> float:
        """Return the time since the epoch [s] at which all drives have stopped; inf during an endless move or if a law
        depends on time."""
        if ("clock", "") in self._at or self.waves:
            return inf
        moving = (a for a in self.actuators.values() if a.move.v0 or a.move.d1 or a.move.d2)
        ends = [
            (a.start_ns - epoch_ns) * 1e-9
            + (a.move.duration if a.move.cruise < inf or a.move.speed(a.move.d1) else a.move.d1)
            for a in moving
        ]
        return max([*ends, self.histories.end(epoch_ns)], default=0.0)


class Histories:
    """Piecewise linear time histories of all signals, in pieces with start in local time [s], value and slope."""

    def __init__(self, signals: dict[str, InputSignal], parameters: ParameterLayout, P: np.ndarray) -> None:
        self._P = P
        self._all: list[tuple[slice, list[int], InputSignal]] = []
        for name, s in signals.items():
            if s.times:
                self._all.append((parameters.at["signal", name], [round(t * 1e9) for t in s.times], s))

    def write(self, epoch_ns: int, t: float = 0.0) -> None:
        """Write the pieces of all signal histories that are active at local time t [s] into the parameter block P."""
        now = epoch_ns + round(t * 1e9)
        for at, times, s in self._all:
            i = bisect_right(times, now) - 1
            first = max(i, 0)
            inside = 0 <= i < len(times) - 1
            slope = (s.values[i + 1] - s.values[i]) / ((times[i + 1] - times[i]) * 1e-9) if inside else 0.0
            self._P[at] = [(times[first] - epoch_ns) * 1e-9, s.values[first], slope]

    def breaks(self, epoch_ns: int, after: float) -> list[float]:
        """Return, for each signal history, the first breakpoint after the local time `after` [s]."""
        now = epoch_ns + round(after * 1e9)
        following = ((times, bisect_right(times, now)) for _, times, _ in self._all)
        return [(times[i] - epoch_ns) * 1e-9 for times, i in following if i < len(times)]

    def end(self, epoch_ns: int) -> float:
        """Return the local time [s] after which no signal history changes."""
        return max(((times[-1] - epoch_ns) * 1e-9 for _, times, _ in self._all), default=-inf)


def _follow(k: tuple[float, float, float], s: float) -> float:
    return float(k[0] * s + k[1] * cos(s) + k[2] * sin(s))
