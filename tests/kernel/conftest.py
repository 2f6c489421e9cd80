"""The folders below follow those of the kernel; scenes beside this file, and those of a test, serve all of them."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path += [str(HERE), *sorted({str(path.parent) for path in HERE.rglob("test_*.py")})]
