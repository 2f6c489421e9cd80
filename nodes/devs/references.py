"""References to Python code, `package.module:name` or `path/to/file.py:name`, optionally with arguments: how they are
parsed and imported.

Before importing, callers check with `heavylift.kernel.trust` whether the code may run.
"""

import ast
import threading
from types import ModuleType

from heavylift.kernel.description import user_code
from heavylift.kernel.errors import HeavyliftError, ModelError


class _Importing(threading.local):
    """Modules that the present thread is importing; several threads import when replications run in parallel."""

    def __init__(self) -> None:
        self.modules: list[str] = []


_importing = _Importing()


def read(reference: str) -> tuple[str, str, list[object], dict[str, object]]:
    """Split a reference to a model into module or file, name and arguments; raises ModelError if that is impossible."""
    where = reference.partition("(")[0].rpartition(":")[0]
    if any("\ud800" <= c <= "\udfff" for c in reference):
        raise ModelError(f"{reference!r} does not refer to a model: the file name is not valid UTF-8; rename the file")
    try:
        tree = ast.parse(reference[len(where) + 1 :], mode="eval").body
        if isinstance(tree, ast.Name) and where:
            return where, tree.id, [], {}
        if isinstance(tree, ast.Call) and isinstance(tree.func, ast.Name) and where:
            named = {k.arg: ast.literal_eval(k.value) for k in tree.keywords if k.arg is not None}
            return where, tree.func.id, [ast.literal_eval(x) for x in tree.args], named
    except (SyntaxError, ValueError):
        pass
    raise ModelError(
        f"{reference!r} does not refer to a model: write module:function, such as my_models:build or my_models:ring(4)"
    )


def imported(where: str) -> ModuleType:
    """Import a module by name or file; raises ModelError with the reason if that fails."""
    _importing.modules.append(where)
    try:
        return user_code.imported(where)
    except user_code.Taken as error:
        raise ModelError(f"{where}: a module {error} exists already; give the file another name") from None
    except HeavyliftError:
        raise
    except FileNotFoundError as error:
        raise ModelError(f"{where}: there is no such file") from error
    except ModuleNotFoundError as error:
        if error.name is not None and f"{where}.".startswith(f"{error.name}."):
            raise ModelError(
                f"there is no module {where}, neither in this folder nor installed; check the name"
            ) from error
        raise ModelError(f"{where} cannot be imported: {error}") from error
    except Exception as error:
        raise ModelError(f"{where} cannot be imported: {user_code.raised(error)}") from error
    finally:
        _importing.modules.pop()


def importing() -> str:
    """Return the name of the module that is being imported to build a model, or "" if no import is in progress."""
    return _importing.modules[-1] if _importing.modules else ""
