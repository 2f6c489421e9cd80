"""The text of a scene.

files           the file of a scene, or a bundled one; how files are read
source          the text with the place of every key and value
yaml_errors     what is wrong with a text that is not YAML
extending       a scene over those that it extends; entries that are like others
tables          rows and lugs of blocks, answers of vessels out of tables beside the scene; table_files: CSV and XLSX
meshes          the shape of a block out of a file beside the scene
overlay         one scene over another, settings of the command line
machine_types   types of cranes as files; type_expansion: a crane made of the parts of its type
expressions     arithmetic over their parameters
faults          every error, with file, line and column
units           quantities with units, and the pydantic types that read them
spelling        what is meant by a comma, a dash, a unit that is written out
uncertainty     how uncertain a number is: `480 t +- 3 %`, `460..500 t`, `480 t sd 5 t`
"""

from heavylift.kernel.on_demand import face

face(__name__)
