"""Public names of a package that are imported when they are first used: a process starts with what it needs."""

from __future__ import annotations

TYPE_CHECKING = False  # as type checkers read it; `typing` takes a command 2 ms in which Ctrl-C is not heard
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping


def on_demand(package: str, modules: Mapping[str, str]) -> Callable[[str], object]:
    """The `__getattr__` of a package; `modules`: each public name with its module, relative to the package."""

    def attribute(name: str) -> object:
        if name not in modules:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        from importlib import import_module

        return getattr(import_module(modules[name], package), name)

    return attribute
