"""The keys of a scene file, as frozen pydantic models.

schema, validate  every key, its unit, its default; data through the models, with errors as sentences
quantities        which quantity stands at a path, and whether its uncertainty makes sense
base              names, places, ends; directions and attitudes
described         keys of what the kernel or the plan describes, made of that description
parts             bodies, joints, laws and hooks of a mechanism or machine
environment       what floats, and the waves; floor and boxes that blocks meet; what blows, as forces of a mechanism
actions           the lines of the action list; interlocks: what stops a machine by itself
nodes             models of a user's own; which process hosts which nodes
gear            items of rigging by ID, out of files beside the scene
defaults          settings laid over a scene, also on one number of a list that it leaves to its default
editors           the JSON Schema of scene files
"""

from heavylift.kernel.on_demand import face

face(__name__)
