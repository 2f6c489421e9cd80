"""A controller that moves a load without swing: a PID controller on the swing angle of the rope, whose output is added
to a trapezoidal speed profile.

When the load is ahead of the trolley by the angle theta, it obeys L theta'' + g theta = -a, where a is the acceleration
of the trolley. With the speed v = v_ref + P theta + I (integral of theta) + D theta' this becomes

    (1 + D / L) theta'' + P / L theta' + (g + I) / L theta = -a_ref / L

so P = 2 zeta sqrt(g L) gives the damping ratio zeta. The additional displacement is P times the integral of theta,
which is zero from rest to rest: the trolley arrives where the trapezoidal profile does.
"""

from heavylift.kernel.description.profile import trapezoid
from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import Atomic, Bag, In, Out, seconds
from heavylift.nodes.models import Sample, SetPoint


class Damper(Atomic):
    """Anti-sway controller: moves a trolley by `distance` [m] and damps the swing of its load.

    The move begins at the time `begin` [s], with the `speed` [m/s] and the acceleration `ramp` [m/s2]. `gain` [m/s per
    rad], `integral` [m/s2 per rad] and `derivative` [m per rad] are P, I and D; `most` [m/s] limits the speed
    set-point; a set-point that changes by at most `still` [m/s] is not sent.
    """

    swing = In(Sample)
    speed = Out(SetPoint)

    def __init__(
        self,
        name: str,
        distance: float,
        speed: float,
        ramp: float,
        begin: float = 0.0,
        gain: float = 0.0,
        integral: float = 0.0,
        derivative: float = 0.0,
        most: float = 0.0,
        still: float = 1e-4,
    ) -> None:
        super().__init__(name)
        if not (speed > 0.0 and ramp > 0.0):
            raise ModelError(f"speed {speed:g} m/s and ramp {ramp:g} m/s2 of a damper must be positive")
        self.profile, self.begin = trapezoid(distance, speed, ramp), seconds(begin)
        self.gains, self.most, self.still = (gain, integral, derivative), most or 2.0 * speed, still

    def start(self) -> None:
        """Start the anti-sway controller without a measured swing."""
        self.last: tuple[int, float] | None = None  # time [ns] and angle [rad]
        self.sum = self.said = self.asked = 0.0
        self.passivate()

    def external(self, e: int, x: Bag) -> None:
        """Compute the speed set-point of the trolley from the measured swing."""
        t, angle = self.now.t, x[self.swing][-1].value
        rate = 0.0
        if self.last is not None and t > self.last[0]:
            step = (t - self.last[0]) * 1e-9
            rate = (angle - self.last[1]) / step
            self.sum += 0.5 * step * (angle + self.last[1])
        self.last = t, angle
        p, i, d = self.gains
        reference = self.profile.speed((t - self.begin) * 1e-9) if t >= self.begin else 0.0
        asked = reference + p * angle + i * self.sum + d * rate
        self.asked = min(max(asked, -self.most), self.most)
        if abs(self.asked - self.said) > self.still:
            self.hold_in(0)

    def output(self) -> None:
        """Send the speed set-point of the trolley if it has changed."""
        self.speed.send(SetPoint(self.asked))

    def internal(self) -> None:
        """Record the set-point that was sent, and wait for the next sample of the swing."""
        self.said = self.asked
        self.passivate()
