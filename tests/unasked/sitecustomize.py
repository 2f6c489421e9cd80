"""Suppresses the question how to run a scene in programs that tests start with this folder on their path.

What most tests look at has nothing to do with the choice, which would only cost time; `tests/conftest.py` says whose.
"""

import sys
from importlib.abc import Loader, MetaPathFinder
from importlib.util import find_spec
from types import ModuleType

MODULE = "heavylift.nodes.scene.loaded_scene"


class Unasked(MetaPathFinder):
    def find_spec(self, name, path=None, target=None):  # type: ignore[no-untyped-def]
        if name != MODULE:
            return None
        sys.meta_path.remove(self)
        spec = find_spec(name)
        assert spec is not None
        assert spec.loader is not None
        spec.loader = Emptied(spec.loader)
        return spec


class Emptied(Loader):
    def __init__(self, loader: Loader) -> None:
        self._loader = loader

    def exec_module(self, module: ModuleType) -> None:
        self._loader.exec_module(module)
        module.MEANT = ()  # type: ignore[attr-defined]


sys.meta_path.insert(0, Unasked())
