"""Makes the scene modules of this folder and of all test folders below it importable."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path += [str(HERE), *sorted({str(path.parent) for path in HERE.rglob("test_*.py")})]
