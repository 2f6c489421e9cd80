"""`heavylift certificates`: one authority, a key for each process, nothing overwritten, nothing readable by others."""

import stat
from datetime import UTC, datetime, timedelta
from ipaddress import ip_address
from pathlib import Path

import pytest
from heavylift.kernel import ProtocolError
from of_a_yard import finish

x509 = pytest.importorskip("cryptography.x509", reason="no package 'cryptography': certificates cannot be made")

from cryptography.hazmat.primitives.asymmetric.ec import SECP256R1  # noqa: E402
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID  # noqa: E402
from heavylift.coordinator.hosts import Credentials, library, make_certificates  # noqa: E402


def extension(path: Path, kind: type) -> object:
    return x509.load_pem_x509_certificate(path.read_bytes()).extensions.get_extension_for_class(kind).value


def test_the_certificates_command_writes_keys_that_only_their_owner_can_read(tmp_path: Path) -> None:
    code, error = finish(tmp_path, "certificates", "keys", "west", "east", "--host", "10.0.0.1")
    assert (code, error) == (0, "")
    keys = tmp_path / "keys"
    assert stat.S_IMODE(keys.stat().st_mode) == 0o700
    modes = {path.name: stat.S_IMODE(path.stat().st_mode) for path in keys.iterdir()}
    names = ("yard", "coordinator", "west", "east")
    assert modes == {f"{n}.pem": 0o644 for n in names} | {f"{n}.key": 0o600 for n in names}


def test_a_certificate_names_its_process_and_serves_as_client_and_server(keys: Path) -> None:
    certificate = x509.load_pem_x509_certificate((keys / "block.pem").read_bytes())
    assert certificate.subject.get_attributes_for_oid(NameOID.COMMON_NAME)[0].value == "block"
    assert isinstance(certificate.public_key().curve, SECP256R1)
    uses = [ExtendedKeyUsageOID.SERVER_AUTH, ExtendedKeyUsageOID.CLIENT_AUTH]
    assert list(extension(keys / "block.pem", x509.ExtendedKeyUsage)) == uses
    assert extension(keys / "block.pem", x509.BasicConstraints) == x509.BasicConstraints(False, None)
    assert extension(keys / "yard.pem", x509.BasicConstraints) == x509.BasicConstraints(True, 0)


def test_the_coordinator_certificate_is_valid_for_all_its_addresses(keys: Path) -> None:
    names = extension(keys / "coordinator.pem", x509.SubjectAlternativeName)
    assert names.get_values_for_type(x509.DNSName) == ["localhost"]
    addresses = ["127.0.0.1", "::1", "10.77.0.1"]
    assert names.get_values_for_type(x509.IPAddress) == [ip_address(a) for a in addresses]


def test_the_certificates_command_keeps_existing_keys(tmp_path: Path) -> None:
    make_certificates(tmp_path, ["west"])
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert [path.name for path in make_certificates(tmp_path, ["west", "east"])] == ["east.pem", "east.key"]
    assert {name: (tmp_path / name).read_bytes() for name in before} == before
    Credentials.load(tmp_path, "east")


def refusal(directory: Path, name: str) -> str:
    with pytest.raises(ProtocolError) as error:
        Credentials.load(directory, name)
    return str(error.value)


def test_missing_invalid_and_publicly_readable_key_files_are_reported_by_name(tmp_path: Path) -> None:
    make_certificates(tmp_path, ["west", "east"])
    make_certificates(tmp_path / "other", ["west"])
    assert refusal(tmp_path, "north") == (
        f"{tmp_path}/north.pem is missing, it belongs to the certificates of 'north'; "
        f"make them with 'heavylift certificates {tmp_path} north'"
    )
    for end in ("pem", "key"):
        (tmp_path / f"south.{end}").write_bytes((tmp_path / f"west.{end}").read_bytes())
    (tmp_path / "south.key").chmod(0o644)
    assert refusal(tmp_path, "south").endswith(f"make it private: chmod 600 {tmp_path}/south.key")
    (tmp_path / "south.key").chmod(0o600)
    assert (
        refusal(tmp_path, "south") == f"{tmp_path}/south.pem was issued to 'west', not to 'south'; copy the right one"
    )
    (tmp_path / "west.pem").write_bytes((tmp_path / "other" / "west.pem").read_bytes())
    assert "was not signed by" in refusal(tmp_path, "west")
    (tmp_path / "east.pem").write_text("no certificate")
    assert (
        refusal(tmp_path, "east") == f"{tmp_path}/east.pem is not a valid certificate; delete it and create a new one"
    )


def test_an_expired_certificate_is_reported_with_its_dates(tmp_path: Path) -> None:
    make_certificates(tmp_path, [])
    use = library()
    signer = use.x509_of(tmp_path / "yard.pem"), use.key_of(tmp_path / "yard.key")
    pem, key = use.pems(*use.leaf("west", ("west",), -1 / 48, signer))
    (tmp_path / "west.pem").write_bytes(pem)
    (tmp_path / "west.key").write_bytes(key)
    (tmp_path / "west.key").chmod(0o600)
    until = datetime.now(UTC) - timedelta(minutes=30)
    assert f"to {until:%Y-%m-%d} only; create a new one" in refusal(tmp_path, "west")


@pytest.mark.parametrize("name", ["yard", "observer", "afar", "a b", ""])
def test_reserved_process_names_get_no_certificate(tmp_path: Path, name: str) -> None:
    with pytest.raises(ProtocolError, match="cannot be used"):
        make_certificates(tmp_path, [name])
    assert not list(tmp_path.iterdir())
