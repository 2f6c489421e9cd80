"""Modules shared by the scripts of tests/bench; puts the tests' kernel scenes on the import path."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "kernel"))
