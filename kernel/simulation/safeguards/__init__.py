"""Safeguards of a run, which refuse or damp unreliable motions or add warnings, so that inaccurate results always carry
a warning.

step_check         a fixed step that is unstable or does not resolve the fastest motion; energy created by steps
chatter            ropes that switch between slack and taut too fast; too many steps or events
deflection_check   flexible bodies at the limits of their theory
failures           why a run cannot go on; bodies without inertia
"""

from heavylift.kernel.on_demand import face

face(__name__)
