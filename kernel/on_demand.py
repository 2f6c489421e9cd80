"""Public names of a package, imported on first use, so that a process imports only what it uses."""

from __future__ import annotations

import sys

TYPE_CHECKING = False  # as type checkers read it; `typing` takes a command 2 ms in which Ctrl-C is not heard
if TYPE_CHECKING:
    from ast import stmt
    from collections.abc import Callable
    from pathlib import Path
    from typing import Any

_known: dict[str, dict[str, list[str]]] = {}  # package -> name -> the modules that define it
_declared: dict[str, dict[str, str]] = {}  # package -> name that it declares -> its module


def on_demand(package: str) -> Callable[[str], object]:
    """Return the `__getattr__` of a package that imports, on first use, the names which the package imports for type
    checkers only."""

    def attribute(name: str) -> object:
        from importlib import import_module

        if package not in _declared:
            _declared[package] = _imports(sys.modules[package].__file__ or "")
        if name not in _declared[package]:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(_declared[package][name], package), name)

    return attribute


def _imports(file: str) -> dict[str, str]:
    """Return, for each name that a file imports below `if TYPE_CHECKING:`, the module that it comes from."""
    import ast
    from pathlib import Path

    body = ast.parse(Path(file).read_text(encoding="utf-8")).body
    checked = (x for part in body if isinstance(part, ast.If) for x in part.body if isinstance(x, ast.ImportFrom))
    return {name.name: f"{'.' * x.level}{x.module}" for x in checked for name in x.names}


def face(package: str) -> None:
    """Make a package import, on first use, each public name that exactly one of its modules defines.

    Names that the package imports itself, or by `on_demand`, take precedence.
    """
    module: Any = sys.modules[package]
    declared = getattr(module, "__getattr__", None)

    def attribute(name: str) -> object:
        from importlib import import_module
        from pathlib import Path

        try:
            if declared:
                return declared(name)
        except AttributeError:
            pass
        folder = Path(module.__file__).parent
        hidden = name.startswith("_") or (folder / f"{name}.py").exists()  # of a package's module, not of its face
        if not hidden and len(found := _definitions(package, folder).get(name, [])) == 1:
            return getattr(import_module(f".{found[0]}", package), name)
        raise AttributeError(f"module {package!r} has no attribute {name!r}")

    module.__getattr__ = attribute


def _definitions(package: str, folder: Path) -> dict[str, list[str]]:
    """Return, for each name, the modules of a folder that define it at top level."""
    import ast

    if package not in _known:
        found: dict[str, list[str]] = {}
        for path in sorted(folder.glob("[a-z]*.py")):
            for statement in ast.parse(path.read_text(encoding="utf-8")).body:
                for name in sorted(set(_names(statement))):
                    if path.stem not in found.setdefault(name, []):
                        found[name].append(path.stem)
        _known[package] = found
    return _known[package]


def _names(statement: stmt) -> list[str]:
    import ast

    match statement:
        case ast.ClassDef(name=name) | ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name):
            return [name]
        case ast.Assign(targets=targets):
            return [x.id for target in targets for x in ast.walk(target) if isinstance(x, ast.Name)]
        case ast.AnnAssign(target=ast.Name(id=name)):
            return [name]
    return []
