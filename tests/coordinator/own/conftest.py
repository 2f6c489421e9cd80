"""One folder of scenes with models beside them, which this user trusts."""

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from heavylift.kernel import allowed


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    found = tmp_path_factory.mktemp("own")
    shutil.copy(Path(__file__).with_name("beside.py"), found)
    with allowed([str(found)]):
        yield found
