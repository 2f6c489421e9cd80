"""What a run refuses, calms or warns of, so that inaccurate results always carry a warning.

inertia_check      something resists every motion
energy_check       energy that comes out of nothing, or goes there
step_check         a fixed step that is unstable or does not follow what moves; fastest_mode: which motion that is
progress_limit     too many steps or events: the run stops making progress
chatter            ropes that go slack and taut faster than a run can resolve
deflection_check   flexible bodies at the limits of their theory
failures           why a run cannot go on
"""

from heavylift.kernel.on_demand import face

face(__name__)
