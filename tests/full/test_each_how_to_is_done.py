"""Every block of HOWTO.md, in its order, prints the output shown on the page."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "pages"))
from page_blocks import blocks, follow

PAGE = "coordinator/HOWTO.md"


def test_every_command_and_example_of_the_how_to_page_succeeds(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for package in ("pandas", "cryptography"):
        pytest.importorskip(package, reason=f"no package {package}")
    done = follow(PAGE, tmp_path, capfd, monkeypatch)
    assert done >= sum(language in ("sh", "python") for language, _ in blocks(PAGE))
