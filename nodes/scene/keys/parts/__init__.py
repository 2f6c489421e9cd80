"""The keys of what is made of parts: a mechanism, or a machine as its type makes it.

mechanics, joints, forces, contacts, flexible   the keys of `mechanism:`
machines        what types make of their parameters
standing        what machines stand on, and the ground below
rigging         what hangs on their hooks: slings, equalisers, frames
kinematics      where bodies are at the start
"""

from heavylift.kernel.on_demand import face

face(__name__)
