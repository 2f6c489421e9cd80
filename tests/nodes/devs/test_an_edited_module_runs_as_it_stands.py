"""Within one session, edited code runs in its present text, and unchanged modules stay loaded."""

from __future__ import annotations

import os
import pickle
import sys
from collections.abc import Callable
from pathlib import Path
from random import Random

import pytest
from heavylift.kernel import ModelError
from heavylift.nodes.devs import Message, imported

LIST = "import sys\nsys.__dict__.setdefault('executed', []).append(__name__)\n"


@pytest.fixture
def write(own_modules: Path) -> Callable[[str, str], Path]:
    """Writes a module of the test's folder."""

    def written(name: str, text: str) -> Path:
        file = own_modules / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
        os.utime(file, (1e9, 1e9))  # one second for all versions, so that no date distinguishes them
        return file

    return written


WAYS = {
    "file.py": ("a.py", "a.py", ""),
    "module": ("a", "a.py", ""),
    "module of a package": ("pack.sub.a", "pack/sub/a.py", ""),
    "package": ("pack", "pack/__init__.py", ""),
    "helper of a file": ("a.py", "h.py", "from h import W"),
    "helper of a module": ("a", "h.py", "import h\nW = h.W"),
    "everything of a helper": ("a", "h.py", "from h import *"),
    "helper of a helper": ("a", "h.py", "from between import W"),
    "module beside it in a package": ("pack.a", "pack/h.py", "from .h import W"),
    "module above it in a package": ("pack.sub.a", "pack/h.py", "from .. import h\nW = h.W"),
    "package above it": ("pack.sub.a", "pack/sub/__init__.py", "from . import W"),
    "helper by importlib": ("a", "h.py", "from importlib import import_module\nW = import_module('h').W"),
    "helper by a name that is computed": ("a", "h.py", "import importlib\nW = importlib.import_module(chr(104)).W"),
    "relative helper by importlib": (
        "pack.a",
        "pack/h.py",
        "import importlib\nW = importlib.import_module('.h', __package__).W",
    ),
    "helper imported by a function": ("a", "h.py", "def w():\n    import h\n    return h.W\nW = w()"),
}


@pytest.mark.parametrize("way", WAYS)
def test_an_edited_model_file_is_read_again_by_the_next_run(way: str, write: Callable[[str, str], Path]) -> None:
    where, edited, text = WAYS[way]
    for package in ("pack/__init__.py", "pack/sub/__init__.py"):
        write(package, "")
    write("between.py", "from h import W\n")
    if text:
        write(where if where.endswith(".py") else f"{where.replace('.', '/')}.py", f"{LIST}{text}\n")
    found = []
    for w in (1, 2, 2, 3):
        write(edited, f"W = {w}\n")  # of equal size
        found.append(imported(where))
        assert w == found[-1].W
    assert found[1] is found[2], "what has not changed is imported again"


@pytest.mark.large(beyond=3)
@pytest.mark.parametrize("seed", range(12))
def test_every_random_edit_of_a_python_module_is_loaded_by_the_next_run(
    seed: int, write: Callable[[str, str], Path]
) -> None:
    """Each import is worth what its modules say now; none is executed if nothing was edited that it depends on."""
    random = Random(seed)
    names = [f"{'pack.' if random.random() < 0.4 else ''}m{seed}_{i}" for i in range(7)]
    uses = {name: random.sample(names[:i], random.randint(0, min(i, 3))) for i, name in enumerate(names)}
    styles = {name: random.choice(("import {0}", "from {1} import {2}", "")) for name in names}
    numbers, edits, executed, seen = dict.fromkeys(names, 0), dict.fromkeys(names, 0), list[str](), dict[str, int]()
    write("pack/__init__.py", "")
    sys.__dict__["executed"] = executed

    def save(name: str) -> None:
        lines = [f"V = {numbers[name]}"]
        for used in uses[name]:
            base, _, last = used.rpartition(".")
            style = styles[used] if base or styles[used] != "from {1} import {2}" else "import {0}"
            lines.append(style.format(used, base, last) or f"import importlib; importlib.import_module('{used}')")
            lines.append(f"import sys; V = 3 * V + sys.modules['{used}'].V")
        write(f"{name.replace('.', '/')}.py", LIST + "\n".join(lines) + "\n")

    def worth(name: str) -> int:
        v = numbers[name]
        for used in uses[name]:
            v = 3 * v + worth(used)
        return v

    def closure(name: str) -> set[str]:
        return {name}.union(*map(closure, uses[name]))

    for name in names:
        save(name)
    for _ in range(40):
        name = random.choice(names)
        if random.random() < 0.5:
            edits[name] += numbers[name] != (number := random.randint(0, 9))
            numbers[name] = number
            save(name)
        else:
            before = len(executed)
            assert worth(name) == imported(name).V, (seed, name)
            for each in closure(name):
                edited = sum(edits[x] for x in closure(each))
                assert executed[before:].count(each) <= (edited != seen.get(each)), (seed, name, each)
                seen[each] = edited


def test_a_module_that_the_python_session_itself_has_imported_is_not_loaded_again(
    write: Callable[[str, str], Path],
) -> None:
    write("mine.py", "from heavylift.nodes.devs import Message\nclass Mine(Message):\n    x: int = 1\n")
    import mine  # type: ignore[import-not-found]

    assert imported("mine") is mine
    assert imported("mine.py") is mine
    write("mine.py", "from heavylift.nodes.devs import Message\nclass Mine(Message):\n    x: int = 2\n")
    assert imported("mine").Mine() != mine.Mine()
    assert mine.Mine().x == 1


def test_a_file_with_a_syntax_error_does_not_run_its_earlier_version(write: Callable[[str, str], Path]) -> None:
    write("a.py", "W = 1\n")
    for where in ("a", "a.py"):
        imported(where)
        write("a.py", "W = (\n")
        for _ in range(2):
            with pytest.raises(ModelError, match=r"a.* cannot be imported: SyntaxError"):
                imported(where)
        write("a.py", "W = 2\n")
        assert imported(where).W == 2


MESSAGE = "from heavylift.nodes.devs import Message\nclass Edited(Message):\n    x: int\n"


def test_a_message_class_may_move_to_another_module_between_two_runs(
    write: Callable[[str, str], Path],
) -> None:
    write("a.py", MESSAGE)
    imported("a")
    write("h.py", MESSAGE)
    write("a.py", "from h import Edited\n")
    assert imported("a").Edited(1).x == 1
    write("a.py", f"import h\n{MESSAGE}")
    with pytest.raises(ModelError, match="message Edited is defined in h and again in a"):
        imported("a")


def test_a_message_of_an_edited_message_class_can_be_pickled(write: Callable[[str, str], Path]) -> None:
    write("a.py", MESSAGE)
    message: Message = imported("a").Edited(7)
    write("a.py", f"{MESSAGE}    y: int = 3\n")
    new = imported("a").Edited
    assert pickle.loads(pickle.dumps(message)) == new(7, 3)
    write("a.py", f"{MESSAGE}    z: int\n")
    imported("a")
    with pytest.raises(ModelError, match=r"message Edited cannot be decoded: .*`z`"):
        pickle.loads(pickle.dumps(message))
