"""The text of a scene.

files           the file of a scene, or a bundled one; safe reading of files
source          the text with the place of every key and value
extending       a scene merged over those that it extends; entries that are like others
tables          rows and lugs of blocks, responses of vessels from tables beside the scene; table_files: CSV and XLSX
meshes          the shape of a block from a file beside the scene
overlay         settings of the command line, applied to a scene
machine_types   machine types as files; type_expansion: a crane expanded to the parts of its type
expressions     arithmetic; parameters: values that may be expressions of one another
faults          every error, with file, line and column
units           quantities with units, and the pydantic types that read them
spelling        tokens; hints for decimal commas, dashes, spelled-out units, and for errors of YAML
uncertainty     the uncertainty of a number: `480 t +- 3 %`, `460..500 t`, `480 t sd 5 t`
"""

from heavylift.kernel.on_demand import face

face(__name__)
