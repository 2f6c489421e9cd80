"""What the stories of several hosts share: certificates of a yard, and the digest of `lift`."""

from pathlib import Path

import pytest
from of_a_yard import digest_in_one_process


@pytest.fixture(scope="session")
def keys(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A directory with certificates for `block`, `crane` and `yard-b`."""
    pytest.importorskip("cryptography", reason="no package 'cryptography': certificates cannot be made")
    from heavylift.coordinator.hosts import make_certificates

    directory = tmp_path_factory.mktemp("yard") / "keys"
    make_certificates(directory, ["block", "crane", "yard-b"], hosts=["10.77.0.1"])
    return directory


@pytest.fixture(scope="session")
def truth(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Digest of `lift` in the coordinator's process."""
    return digest_in_one_process(tmp_path_factory.mktemp("truth"))
