"""Every block of code on the page about DEVS runs, one after the other, and its asserts hold."""

import re
import sys
from pathlib import Path
from types import ModuleType

import pytest

PAGE = (Path(__file__).parents[3] / "nodes" / "devs" / "DEVS.md").read_text()
BLOCKS, ASSERTS = 8, 11


def test_all_code_blocks_of_the_documentation_page_about_devs_can_be_executed(monkeypatch: pytest.MonkeyPatch) -> None:
    blocks = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    page = ModuleType("page_about_devs")
    monkeypatch.setitem(sys.modules, page.__name__, page)
    for block in blocks:
        exec(compile(block, "DEVS.md", "exec"), page.__dict__)
    assert len(blocks) == BLOCKS
    assert sum(block.count("assert ") for block in blocks) == ASSERTS
