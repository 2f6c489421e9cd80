"""What the scripts of tests/bench share; from here on the tests' scenes of the kernel can be imported, too."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "kernel"))
