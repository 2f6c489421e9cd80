"""The text of a scene.

opening         the file of a scene, or a bundled one
source, files   the text with the place of every key and value; how files are read
extending       a scene over those that it extends; entries that are like others
tables          rows and lugs of blocks, answers of vessels out of tables beside the scene; table_files: CSV and XLSX
meshes          the shape of a block out of a file beside the scene
overlay         one scene over another, settings of the command line
machine_types   types of cranes as files; type_expansion: a crane made of the parts of its type
expressions     arithmetic over their parameters
rewriting       other values in the text, all else as it was written
faults          every error, with file, line and column
units           quantities with units, and the pydantic types that read them
uncertainty     how uncertain a number is: `480 t +- 3 %`, `460..500 t`, `480 t sd 5 t`
"""

from heavylift.kernel.on_demand import face

face(__name__)
