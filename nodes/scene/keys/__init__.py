"""The keys of a scene file, as frozen pydantic models.

schema, validate       every key, its unit, its default; data through the models, with errors as sentences
quantities             which quantity stands at a path, and whether its uncertainty makes sense
base, attitudes        names, places, ends; directions and attitudes
mechanics, joints, forces, contacts, flexible   the keys of `mechanism:`
machines               what types make of their parameters, and what hangs on their hooks
kinematics             where the bodies of a mechanism are at the start
actions                                        the lines of the action list
placement              which process hosts which nodes
editors                the JSON Schema of scene files
"""
