"""Computes the digests of the bundled scenes in this process; without arguments it stores them as expected ones.

python tests/determinism/digests.py                              writes tests/data/digests.json
python tests/determinism/digests.py lift --processor haswell     prints those of some scenes, as JSON
"""

from __future__ import annotations

import argparse
import functools
import json
import tempfile
from pathlib import Path

from heavylift.coordinator.run import run
from heavylift.kernel.compiler import emit as native
from heavylift.nodes.scene import LoadedScene, bundled, load

STORED = Path(__file__).parents[1] / "data" / "digests.json"


def digest(scene: LoadedScene) -> str:
    """Of a run of the scene in this process."""
    with tempfile.TemporaryDirectory() as folder:
        return run(scene, Path(folder) / "run.mcap", in_process=True).digest


def digests(names: list[str]) -> dict[str, str]:
    """Of bundled scenes, by name."""
    return {name: digest(load(name)) for name in names}


def stored() -> dict[str, str]:
    """What tests expect."""
    return dict(json.loads(STORED.read_text()))


def main() -> None:
    """What the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*")
    parser.add_argument("--processor", help="LLVM's name of the one whose instructions are used")
    asked = parser.parse_args()
    if asked.processor:
        made = native.Library.__init__
        native.Library.__init__ = functools.partialmethod(made, cpu=asked.processor)  # type: ignore[assignment]
    found = digests(asked.scenes or sorted(bundled()))
    if asked.scenes:
        print(json.dumps(found))
    else:
        STORED.write_text(json.dumps(found, indent=2) + "\n")


if __name__ == "__main__":
    main()
