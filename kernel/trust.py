"""Rules for which Python code may run: code that the user names himself, and code in folders that he has trusted.

A scene, a recording or a coordinator is data written by others, so the code that it names is checked before it is
imported: every file that the import would execute is checked, with links and `..` resolved. `heavylift trust DIR` adds
a folder to the user's configuration, as git's safe.directory does; a folder that others can write to is not trusted.
Trust in a folder does not include packages installed below it. Names on a command line reach the processes of the run
through the environment.
"""

import functools
import importlib.util
import json
import os
import stat
import sys
import sysconfig
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from importlib.machinery import ModuleSpec
from pathlib import Path
from shlex import quote
from types import ModuleType
from typing import Any

from .errors import KernelError

ALLOWED = "HEAVYLIFT_ALLOW_CODE"
ROOMS = ("kernel", "nodes", "coordinator", "recordings", "__init__.py")  # the last is there where it is installed
HEAVYLIFT = [Path(__file__).resolve().parents[1] / room for room in ROOMS]
MODELS = (HEAVYLIFT[1] / "zoo", HEAVYLIFT[2] / "yards" / "model.py")  # functions of heavylift that may be named
STANDARD = Path(sysconfig.get_path("stdlib")).resolve()
LIBRARIES = [Path(sysconfig.get_path(x)).resolve() for x in ("purelib", "platlib")]  # may lie below the one above
MOST = 1 << 20  # of the list [bytes]

_named: dict[str, str] = {}


def refusal(where: str, reference: str = "") -> str:
    """Return why the code of a module or file.py must not run, with the command that allows it; "" if it may run.

    Also "" if it does not exist. `reference`: the complete reference, which a command line may have allowed literally.
    """
    given = _allowed()
    if reference and reference in given:
        return ""
    try:
        files = list(_executed(where))
    except (ValueError, OSError, RuntimeError, ImportError):
        return f"{where!r} names no module"
    for file in files:
        if file is None or (file.is_relative_to(STANDARD) and not _among(LIBRARIES, file)):
            return f"'{where}' belongs to Python itself; name a function of your own"
        if _among(HEAVYLIFT, file) or _among(map(Path, given), file):
            continue
        roots = [root for root in trusted() if file.is_relative_to(root) and not _installed(root, file)]
        if not roots:
            message = f"'{where}' is code in a folder that you have not trusted; read it, then type: heavylift trust"
            return f"{message} {quote(str(_folder(where, file)))}"
        root = max(roots, key=lambda x: len(x.parts))
        cached = Path(importlib.util.cache_from_source(str(file)))
        for path in (file, *file.parents, cached, cached.parent):
            if path.is_relative_to(root) and (why := others_write(path)):
                return f"'{where}' is not safe to run: {path} {why}"
    return ""


def foreign(function: object, reference: str = "") -> str:
    """Return why a function must not be called although it was found in a trusted module; "" if it may be called."""
    while isinstance(function, functools.partial):
        function = function.func
    where = getattr(function, "__module__", None) or type(function).__module__
    file = next(reversed([*_executed(where)]), None)
    tool = file is not None and _among(HEAVYLIFT, file) and not _among(MODELS, file)
    if reference in _allowed() or not (tool or refusal(where)):
        return ""
    return f"it is written in {where}, not by those whom you trust to write models and laws"


def named(references: Iterable[str], by: str = "") -> None:
    """Register Python functions to which data refer, so that they are checked before use; `by`: origin of the data."""
    for reference in references:
        _named[reference] = by or _named.get(reference, "")


def demand(references: Iterable[str], by: str) -> None:
    """Check and register Python functions to which data refer; raises KernelError if one must not run."""
    references = [*references]
    named(references, by)
    for reference in references:
        if why := refusal(reference.rpartition(":")[0], reference):
            raise KernelError(f"{by}: {why}")


def namer(reference: str) -> str | None:
    """Return the origin of data that refer to a function; "" if the origin is unknown, None if no data refer to it."""
    return _named.get(reference)


def trusted() -> list[Path]:
    """Return the sorted folders and files that this user trusts; raises KernelError if others can change the list."""
    path = _list()
    try:
        with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK), "rb") as file:
            regular = stat.S_ISREG(os.fstat(file.fileno()).st_mode)
            text = file.read(MOST).decode() if regular else ""
    except FileNotFoundError:
        return []
    except (OSError, UnicodeDecodeError) as error:
        raise KernelError(f"{path} cannot be read ({error}); it is your list of trusted folders") from None
    why = "is no regular file" if not regular else others_write(path) or others_write(path.parent)
    if why:
        raise KernelError(f"{path}, your list of trusted folders, is not safe: it {why}")
    return [Path(line) for line in text.splitlines() if line.startswith("/")]


def trust(folder: Path) -> Path:
    """Trust a folder or file, return its resolved path; raises KernelError if missing or changeable by other users."""
    folder = folder.expanduser().resolve()
    if not (folder.is_dir() or folder.is_file()):
        raise KernelError(f"there is no folder {folder}; trust the folder that holds the code")
    if why := others_write(folder):
        raise KernelError(f"{folder} cannot be trusted: it {why}")
    if folder == Path(folder.anchor) or "\n" in str(folder):
        why = "it is the whole disk, or its name has a line break"
        raise KernelError(f"{str(folder)!r} cannot be trusted: {why}; trust the folder that holds the code")
    _keep({*trusted(), folder})
    return folder


def withdraw(folder: Path) -> Path:
    """Withdraw the user's trust in a folder and return its path; raises KernelError if it was not trusted."""
    known = trusted()
    found = next((x for x in (folder.expanduser().resolve(), folder.absolute()) if x in known), None)
    if found is None:
        raise KernelError(f"{folder} is not among the trusted folders; `heavylift trust` lists them")
    _keep({*known} - {found})
    return found


def written_by_user(module: str) -> bool:
    """Return whether a module is the user's own: not part of Python, heavylift or another installed package."""
    file = getattr(sys.modules.get(module), "__file__", None)
    return file is not None and own_file(file)


def own_file(file: str) -> bool:
    """Return whether a file is the user's own: not part of Python, heavylift or another installed package."""
    return not _among((STANDARD, *LIBRARIES, *HEAVYLIFT), Path(file).resolve())


def written_by_others(file: str) -> bool:
    """Return whether a file is not heavylift's own code; its bundled models count as written by others."""
    path = Path(file).resolve()
    return not _among(HEAVYLIFT, path) or _among(MODELS, path)


@contextmanager
def allowed(names: Iterable[str]) -> Iterator[None]:
    """Context in which the code of the given files, folders or functions may run, also in child processes."""
    before = os.environ.get(ALLOWED)
    os.environ[ALLOWED] = json.dumps([*_allowed(), *names])
    try:
        yield
    finally:
        if before is None:
            os.environ.pop(ALLOWED, None)
        else:
            os.environ[ALLOWED] = before


def others_write(path: Path, found: os.stat_result | None = None) -> str:
    """Return why another user could write to a path, with the remedy; "" if none can. `found`: the path's status, if
    known."""
    try:
        found = found or path.lstat()
    except OSError:
        return ""
    if not hasattr(os, "getuid"):
        return ""
    if found.st_uid not in (os.getuid(), 0):
        return f"belongs to another user; copy it, or change its owner: chown {os.getuid()} {quote(str(path))}"
    shared = stat.S_IWOTH | (0 if _alone(found.st_gid) else stat.S_IWGRP)
    if found.st_mode & shared and not stat.S_ISLNK(found.st_mode):
        return f"can be written by other users; take that from them: chmod go-w {quote(str(path))}"
    return ""


def _alone(group: int) -> bool:
    """Return whether a group is the private group of this user."""
    import grp
    import pwd

    try:
        user, found = pwd.getpwuid(os.getuid()), grp.getgrgid(group)
    except KeyError:
        return False
    return found.gr_name == user.pw_name and not {*found.gr_mem} - {user.pw_name}


def _allowed() -> list[str]:
    try:
        return [str(x) for x in json.loads(os.environ.get(ALLOWED, "[]"))]
    except (ValueError, TypeError):
        return []


def _list() -> Path:
    base = os.environ.get("XDG_CONFIG_HOME") or "~/.config"
    try:
        return (Path(base).expanduser() / "heavylift" / "trusted-folders").resolve()
    except RuntimeError as error:
        raise KernelError(f"the list of trusted folders cannot be stored ({error}); set XDG_CONFIG_HOME") from None


def _keep(folders: Iterable[Path]) -> None:
    path = _list()
    part = path.with_name(f"{path.name}.{os.getpid()}")
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        with open(os.open(part, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as file:
            file.writelines(f"{folder}\n" for folder in sorted(folders))
        part.replace(path)
    except OSError as error:
        raise KernelError(f"{path} cannot be written ({error.strerror}); it is your list of trusted folders") from None


def _executed(where: str) -> Iterator[Path | None]:
    """Yield the files that an import would execute, packages first; None for modules without file."""
    if where.endswith((".py", ".fmu")):
        path = Path(where).resolve()
        if path.is_file():
            yield path
        return
    inside: Any = None
    for end in (i for i, c in enumerate(f"{where}.") if c == "."):
        spec = _spec(where[:end], inside)
        if spec is None:
            if where[:end] in sys.modules:
                yield None
            return
        inside = spec.submodule_search_locations
        if spec.has_location and spec.origin:
            yield Path(spec.origin).resolve()
        elif inside is None:
            yield None


def _spec(name: str, inside: Any) -> Any:
    known: ModuleType | None = sys.modules.get(name)
    if known is not None and known.__spec__ is not None:
        return known.__spec__
    if known is not None and (file := getattr(known, "__file__", None)):
        return importlib.util.spec_from_file_location(name, file)
    finders = (finder.find_spec for finder in sys.meta_path if hasattr(finder, "find_spec"))
    try:
        return next((spec for find in finders if name and (spec := find(name, inside)) is not None), None)
    except KeyError:  # a folder without a file of its own in a package that is not imported
        found = ModuleSpec(name, None, is_package=True)
        found.submodule_search_locations = [str(Path(x) / name.rpartition(".")[2]) for x in inside]
        return found


def _installed(root: Path, file: Path) -> bool:
    """Return whether a file belongs to a package installed below a folder."""
    return _among((library for library in LIBRARIES if root in library.parents), file)


def _among(roots: Iterable[Path], file: Path) -> bool:
    return any(map(file.is_relative_to, roots))


def _folder(where: str, file: Path) -> Path:
    """Return the folder to trust for a file: its own, or for a module in a package that of the whole package."""
    outermost = next((x for x in _executed(where.partition(".")[0]) if x), file) if "/" not in where else file
    return outermost if outermost.parent in LIBRARIES else outermost.parent
