"""Reading the text of a scene: files, tables, expressions, machine types, units, and the place of every value.

files           the file of a scene, or a bundled one; safe reading of files
source          the data of a scene, with the place in the text of every key and value
extending       a scene merged over those that it extends; entries that are `like` others
tables          blocks, lugs and responses of vessels from tables in the scene's folder; table_files: CSV and XLSX
meshes          the shape of a block from a file in the scene's folder
overlay         settings from the command line, applied to a scene
machine_types   machine types as files; type_expansion: expansion of a crane to the parts of its type
expressions     arithmetic; parameters: values that may be expressions of one another
faults          error messages with file, line and column
units           quantities with units, and the pydantic types that read them
spelling        tokens; hints for decimal commas, dashes, spelled-out units; explanations of YAML errors
uncertainty     numbers with uncertainty: `480 t +- 3 %`, `460..500 t`, `480 t sd 5 t`
"""

from heavylift.kernel.on_demand import face

face(__name__)
