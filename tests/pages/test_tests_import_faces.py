"""Tests import names from packages instead of their modules, so that modules can move without changing tests."""

from __future__ import annotations

import ast
import re
from importlib import import_module
from pathlib import Path

TESTS = Path(__file__).parents[1]
DEEP = re.compile(r"heavylift\.\w+\.")


def test_tests_import_public_names_from_packages_and_not_from_modules() -> None:
    deep = [x for path in sorted(TESTS.rglob("*.py")) for x in _deep_imports(path)]
    assert not deep, "\n".join(deep)


def _deep_imports(path: Path) -> list[str]:
    """Names that a test imports from a module although the package above it offers them."""
    found = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and DEEP.match(node.module or ""):
            module, above = import_module(str(node.module)), import_module(str(node.module).rpartition(".")[0])
            if not hasattr(module, "__path__"):
                offered = [a.name for a in node.names if getattr(above, a.name, None) is getattr(module, a.name)]
                found += [f"{path.relative_to(TESTS)}:{node.lineno}: {node.module} import {x}" for x in offered]
    return found
