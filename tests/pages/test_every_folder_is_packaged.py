"""Each folder of a room is an installed package with at most sixteen files."""

from __future__ import annotations

import ast
import tomllib
from pathlib import Path

import pytest
from page_blocks import ROOT

ROOMS = ("kernel", "nodes", "coordinator", "recordings")
FOLDERS = sorted({p.parent.relative_to(ROOT) for room in ROOMS for p in (ROOT / room).rglob("*.py")})
FACE = "coordinator.face"  # what `import heavylift` gives: the package above all others
MOST, AT_THE_TOP = 16, 5  # modules of a folder; of a room, besides its table of contents


def test_the_list_of_packages_in_pyproject_contains_every_package() -> None:
    listed = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"]
    names = [".".join(folder.parts) for folder in FOLDERS]
    assert listed == ["heavylift", *(f"heavylift.{name}" for name in names if name != FACE)]


@pytest.mark.parametrize("folder", FOLDERS, ids=str)
def test_every_package_folder_has_at_most_sixteen_modules(folder: Path) -> None:
    modules = sorted(p.name for p in (ROOT / folder).glob("*.py"))
    assert len(modules) <= MOST
    if len(folder.parts) == 1:
        assert len(modules) - 1 <= AT_THE_TOP


@pytest.mark.parametrize("folder", FOLDERS, ids=str)
def test_a_package_docstring_names_every_module_of_the_package(folder: Path) -> None:
    there = [p.stem for p in (ROOT / folder).glob("*.py") if p.stem != "__init__"]
    text = ast.get_docstring(ast.parse((ROOT / folder / "__init__.py").read_text())) or ""
    assert [name for name in sorted(there) if name not in text.replace("`", " ")] == []
