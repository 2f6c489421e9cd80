"""Imports the user's modules so that the code that runs is the present content of their files.

A module is loaded again once its text, or that of one of the user's modules that it imports, has changed since it was
loaded; other modules stay loaded. Texts are compared, since two edits can share time and size. Objects created by an
earlier version keep using it. Modules imported before heavylift, or by an import hook of another tool, count as changed
if their file is newer than this module.
"""

import ast
import errno
import importlib
import importlib.util
import os
import sys
import time
import traceback
from collections.abc import Iterator, Sequence
from functools import cache, lru_cache
from hashlib import sha256
from importlib.machinery import ModuleSpec, SourceFileLoader
from pathlib import Path
from threading import RLock
from types import CodeType, ModuleType

from heavylift.kernel.errors import error_text
from heavylift.kernel.trust import own_file, written_by_others

_BEGAN_ns = time.time_ns()
_lock = RLock()
_asked = list[str]()  # what `imported` works on
_executing = list[str]()
ANY = "*"  # in place of a name that only running the text tells
INSTALLED = {"site-packages", "dist-packages"}  # beside those of this interpreter


def _own(file: str) -> bool:
    """Return whether a module's file belongs to the user: decided by its folder, or for a link by the file itself."""
    if os.path.islink(file):
        return own_file(file) and INSTALLED.isdisjoint(Path(file).parts)
    return _own_folder(os.path.dirname(file))


@cache
def _own_folder(folder: str) -> bool:
    return own_file(folder) and INSTALLED.isdisjoint(Path(folder).parts)


class Taken(Exception):
    """Raised for a file whose module name already belongs to another module."""


def imported(where: str, name: str = "") -> ModuleType:
    """Import a module, or a file.py as the module `name`; reload it if edited. FileNotFoundError if it is missing."""
    with _lock:
        importlib.invalidate_caches()
        _asked.append(where)
        try:
            if where.endswith(".py"):
                return _of_file(where, name)
            _forget_changed(where)
            return importlib.import_module(where)
        finally:
            _asked.pop()


def _of_file(where: str, name: str) -> ModuleType:
    path = Path(where).resolve()
    name = name or path.stem
    known = sys.modules.get(name)
    if known is not None and Path(known.__file__ or "").resolve() != path:
        raise Taken(name)
    _forget_changed(name)
    if name not in sys.modules:
        if not path.is_file():
            raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), where)
        loader = _Loader(name, str(path))
        spec = importlib.util.spec_from_file_location(name, path, loader=loader)
        assert spec is not None
        sys.modules[name] = module = importlib.util.module_from_spec(spec)
        try:
            loader.exec_module(module)
        except BaseException:
            del sys.modules[name]
            raise
    return sys.modules[name]


class _Loader(SourceFileLoader):
    """Loads a user's module with its source text; uses bytecode only if it is newer."""

    digest = b""

    def get_code(self, fullname: str) -> CodeType | None:
        self.digest = sha256(self.get_data(self.path)).digest()
        return super().get_code(fullname)

    def exec_module(self, module: ModuleType) -> None:
        _executing.append(module.__name__)
        try:
            for used in _uses(module.__name__) if _asked else ():
                _forget_changed(used)
            super().exec_module(module)
        finally:
            _executing.remove(module.__name__)

    def path_stats(self, path: str) -> dict[str, float]:
        kept = importlib.util.cache_from_source(path)
        if os.path.exists(kept) and os.stat(path).st_ctime_ns >= os.stat(kept).st_mtime_ns:
            os.unlink(kept)  # it names its source by second and size
        return dict(super().path_stats(path))


class _Finder:
    """Finds modules as usual, and loads users' modules with `_Loader`."""

    @staticmethod
    def find_spec(name: str, path: Sequence[str] | None = None, target: ModuleType | None = None) -> ModuleSpec | None:
        finders = (x.find_spec for x in sys.meta_path if x is not _Finder and hasattr(x, "find_spec"))
        spec = next((found for find in finders if (found := find(name, path, target)) is not None), None)
        if spec is not None and type(spec.loader) is SourceFileLoader and spec.origin and _own(spec.origin):
            spec.loader = _Loader(name, spec.origin)
        return spec


sys.meta_path.insert(0, _Finder)


def _forget_changed(root: str) -> None:
    """Unload the modules among those that `root` needs whose text has changed, and all modules that need them."""
    reached, new = set[str](), {name for name in _heads(root) if _file(name)}
    while new:
        reached |= new
        new = {used for name in new for used in _uses(name)} - reached
    changed = {name for name in reached if name not in _executing and _changed(name)}
    while changed:
        for name in changed:
            module = sys.modules.pop(name, None)
            package, _, last = name.rpartition(".")
            if module is not None and getattr(sys.modules.get(package), last, None) is module:
                delattr(sys.modules[package], last)  # or `from package import module` finds it there
        gone, changed = changed, set()
        known = (name for name in [*sys.modules] if _file(name) and name not in _executing)
        changed = {name for name in known if not gone.isdisjoint(_uses(name, gone))}


def _file(name: str) -> str:
    """Return the file of a loaded user module; "" for other modules."""
    file = getattr(sys.modules.get(name), "__file__", None) if name != "__main__" else None
    return file if file is not None and file.endswith(".py") and _own(file) else ""


def _changed(name: str) -> bool:
    loader = getattr(getattr(sys.modules.get(name), "__spec__", None), "loader", None)
    try:
        if isinstance(loader, _Loader):
            return loader.digest != sha256(Path(loader.path).read_bytes()).digest()
        return os.stat(_file(name)).st_ctime_ns > _BEGAN_ns
    except OSError:
        return True


def _uses(name: str, also: set[str] = frozenset()) -> set[str]:  # type: ignore[assignment]
    """Return the loaded user modules (or those in `also`) that a module imports itself, with their packages."""
    try:
        text = Path(_file(name)).read_bytes()
    except OSError:
        return set()
    package = getattr(sys.modules.get(name), "__package__", None) or ""
    named = _named(text, package)
    found = {*_heads(package), *(head for answer in named for head in _heads(answer))}
    found |= {*sys.modules, *also} if ANY in named else set()
    return {x for x in found if x != name and (x in also or _file(x))}


def _heads(name: str) -> Iterator[str]:
    """Yield a module and its parent packages, outermost first: a, a.b, a.b.c."""
    return (name[:i] for i, c in enumerate(f"{name}.") if c == "." and i)


@lru_cache(1024)
def _named(text: bytes, package: str) -> frozenset[str]:
    """Return the modules that a text may import, by statements or import functions; with ANY if a name is computed."""
    found = set[str]()
    try:
        nodes = [*ast.walk(ast.parse(text))]
    except (SyntaxError, ValueError, RecursionError):
        nodes = []
    for node in nodes:
        if isinstance(node, ast.Import):
            found |= {x.name for x in node.names}
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) + 1 - node.level] if node.level else []
            base = ".".join([*above, *([node.module] if node.module else [])])
            found |= {base, *(f"{base}.{x.name}" for x in node.names)}
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith(("import_module", "__import__")):
            plain = (isinstance(x, ast.Constant) and str(x.value) for x in node.args[:1])
            found |= {x if x and x[0] != "." else ANY for x in plain}
    return frozenset(found)


def raised(error: BaseException) -> str:
    """Return class and text of an error of user code, with its place in a file that is not part of heavylift."""
    frames = [(x.f_code.co_filename, line) for x, line in traceback.walk_tb(error.__traceback__)]
    at = next((x for of in (_own, written_by_others) for x in reversed(frames) if of(x[0])), None)
    where = f" ({os.path.basename(at[0])}:{at[1]})" if at else ""
    text = error_text(error)
    return f"{type(error).__name__}{': ' if text else ''}{text}{where}"
