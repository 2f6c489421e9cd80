"""Test folders of the kernel follow its packages; scene modules of this folder and of each test's own folder can be
imported."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path += [str(HERE), *sorted({str(path.parent) for path in HERE.rglob("test_*.py")})]
