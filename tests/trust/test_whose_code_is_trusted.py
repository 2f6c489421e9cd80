"""Trust in a folder covers its resolved path and the files in it as long as nobody else can write them."""

from __future__ import annotations

import importlib
import os
from pathlib import Path

import pytest
from heavylift.kernel import KernelError, trust

OTHER = 12345  # another user


@pytest.fixture(autouse=True)
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A trusted folder with a file and a package, the user in the folder above."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "configuration"))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own" / "package" / "inner").mkdir(parents=True)
    for file in ("mine.py", "package/__init__.py", "package/inner/laws.py"):
        (tmp_path / "own" / file).write_text("def push(x):\n    return 0.0\n")
    trust.trust(Path("own"))
    return tmp_path / "own"


def test_everything_inside_a_trusted_folder_is_trusted(own: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(own)
    for where in ("own/mine.py", "own/package/../mine.py", str(own / "mine.py"), "mine", "package.inner.laws"):
        assert trust.refusal(where) == ""


def test_a_symbolic_link_that_leads_out_of_a_trusted_folder_is_not_trusted(own: Path, tmp_path: Path) -> None:
    (tmp_path / "foreign").mkdir()
    (tmp_path / "foreign" / "theirs.py").write_text("")
    (own / "link.py").symlink_to(tmp_path / "foreign" / "theirs.py")
    (own / "below").symlink_to(tmp_path / "foreign")
    (tmp_path / "ownership").mkdir()
    (tmp_path / "ownership" / "theirs.py").write_text("")
    for where in ("own/link.py", "own/below/theirs.py", "own/../foreign/theirs.py", "ownership/theirs.py"):
        folder = tmp_path / ("ownership" if "ownership" in where else "foreign")
        assert trust.refusal(where).endswith(f"type: heavylift trust {folder}")


def test_a_link_in_place_of_a_trusted_folder_is_not_trusted(own: Path, tmp_path: Path) -> None:
    (tmp_path / "foreign").mkdir()
    (tmp_path / "foreign" / "mine.py").write_text("")
    own.rename(tmp_path / "gone")
    own.symlink_to("foreign")
    assert trust.refusal("own/mine.py").endswith(f"heavylift trust {tmp_path / 'foreign'}")


@pytest.mark.parametrize("part", [".", "mine.py"])
def test_python_files_that_other_users_can_write_are_not_trusted(own: Path, part: str) -> None:
    (own / part).chmod(0o777)
    assert trust.refusal("own/mine.py").endswith(f"take that from them: chmod go-w {own / part}")
    assert trust.refusal("own/package/__init__.py" if part == "mine.py" else "own/package/inner/laws.py") == (
        "" if part == "mine.py" else trust.refusal("own/mine.py").replace("own/mine.py", "own/package/inner/laws.py")
    )


def test_a_folder_that_others_can_write_is_not_trusted(own: Path) -> None:
    own.chmod(0o777)
    with pytest.raises(KernelError, match="cannot be trusted: it can be written by other users"):
        trust.trust(own)
    for folder in ("nowhere", "/"):
        with pytest.raises(KernelError):
            trust.trust(Path(folder))


@pytest.mark.skipif(os.getuid() != 0, reason="only root can give a file away")
def test_files_of_other_users_are_not_trusted(own: Path) -> None:
    os.chown(own / "mine.py", OTHER, -1)
    assert "belongs to another user" in trust.refusal("own/mine.py")


def test_the_list_of_trusted_folders_is_readable_by_its_user_only(own: Path, tmp_path: Path) -> None:
    kept = tmp_path / "configuration" / "heavylift" / "trusted-folders"
    kept.chmod(0o666)
    with pytest.raises(KernelError, match=r"your list of trusted folders, is not safe: it can be written"):
        trust.refusal("own/mine.py")
    kept.unlink()
    os.mkfifo(kept)
    with pytest.raises(KernelError, match="is no regular file"):
        trust.refusal("own/mine.py")


def test_trust_of_a_module_depends_on_the_file_that_would_be_imported(own: Path, tmp_path: Path, monkeypatch) -> None:
    """One of the same name that comes first, in the current folder or along a path, is what counts."""
    monkeypatch.syspath_prepend(own)
    assert trust.refusal("mine") == ""
    (tmp_path / "mine.py").write_text("raise SystemExit")
    monkeypatch.syspath_prepend("")
    assert trust.refusal("mine").endswith(f"heavylift trust {tmp_path}")
    (tmp_path / "package").mkdir()
    (tmp_path / "package" / "__init__.py").write_text("raise SystemExit")
    assert trust.refusal("package.inner.laws").endswith(f"heavylift trust {tmp_path / 'package'}")
    (tmp_path / "heavylift").mkdir()
    (tmp_path / "heavylift" / "laws.py").write_text("raise SystemExit")
    assert trust.refusal("heavylift.laws") == ""  # nobody would find it: heavylift is a package of its own
    with pytest.raises(ModuleNotFoundError):
        importlib.import_module("heavylift.laws")


@pytest.mark.parametrize("where", ["heavylift", "heavylift.nodes.zoo", "heavylift.nodes.zoo.none", "heavylift.nodes"])
def test_code_of_heavylift_itself_is_trusted_wherever_it_is_installed(where: str) -> None:
    assert trust.refusal(where) == ""


def test_trust_in_a_folder_does_not_include_packages_installed_below_it(own: Path, monkeypatch) -> None:
    library = own / "venv" / "site-packages"
    library.mkdir(parents=True)
    (library / "theirs.py").write_text("")
    monkeypatch.setattr(trust, "LIBRARIES", [library])
    monkeypatch.syspath_prepend(library)
    assert trust.refusal("theirs").endswith(f"heavylift trust {library / 'theirs.py'}")
    trust.trust(library / "theirs.py")
    assert trust.refusal("theirs") == ""


def test_functions_of_the_python_library_are_refused_as_force_laws() -> None:
    for where in ("os", "shutil", "builtins", "math", "json.decoder", "sys"):
        assert trust.refusal(where) == f"'{where}' belongs to Python itself; name a function of your own"


@pytest.mark.parametrize("where", ["no\0name", "..", ".", "a..b", "x" * 5000, "x" * 5000 + ".py", "no.such.module"])
def test_a_malformed_module_name_in_a_reference_to_code_raises_no_exception(where: str) -> None:
    assert trust.refusal(where) in ("", f"{where!r} names no module")
