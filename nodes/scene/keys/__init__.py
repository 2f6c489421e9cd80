"""The keys of a scene file, defined as frozen pydantic models.

schema            every key, its unit, its default
validate          validation of data, with errors as sentences; settings
quantities        the quantity at a path, and whether an uncertainty is valid for it
base              names, places, ends; directions and attitudes
parts             bodies, joints, laws and hooks of a mechanism or machine
environment       vessels and waves; floor and obstacles; wind, as forces of a mechanism
seas              spectra of irregular seas
actions           the lines of the action list; interlocks
nodes             user models; the process of each node
gear              items of rigging by ID, from files in the scene's folder
editors           the JSON Schema of scene files
"""

from heavylift.kernel.on_demand import face

face(__name__)
