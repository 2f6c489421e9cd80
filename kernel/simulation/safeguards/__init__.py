"""What a run refuses, calms or warns of, so that inaccurate results always carry a warning.

step_check         a fixed step that is unstable or does not follow the fastest motion; energy out of nothing
chatter            ropes that go slack and taut faster than a run can resolve; too many steps or events
deflection_check   flexible bodies at the limits of their theory
failures           why a run cannot go on; what resists no motion
"""

from heavylift.kernel.on_demand import face

face(__name__)
