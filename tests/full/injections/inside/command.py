"""The command `heavylift` with a planned fault in one of its processes: python command.py run lift"""

import sys

sys.path.pop(0)  # this folder, whose modules are those of a package

from injections.inside.striking import PHASE, PLAN, WHO, Imports

if WHO == "coordinator" and PHASE == "import":
    sys.meta_path.insert(0, Imports(PLAN["point"]))
else:
    from injections.inside.coordinator import coordinate

    coordinate()

from heavylift.coordinator.cli import main

sys.exit(main())
