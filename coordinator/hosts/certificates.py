"""Keys and certificates of a yard: who may take part in a run from another host.

Each yard has a certificate authority (`yard.pem`; its key stays on the coordinator's host), which signs a certificate
for the coordinator and one for each remote process; its common name is that process's name. EC P-256, a subject
alternative name (RFC 5280), extendedKeyUsage serverAuth and clientAuth: both ends of a connection present a certificate
and check the other's.

    yard.pem yard.key    coordinator.pem coordinator.key    NAME.pem NAME.key    keys for their owner only (0600)
A process on another host needs three of them: yard.pem, NAME.pem, NAME.key.

Certificates are signed and read by the package `cryptography`, which is imported on first use.
"""

from __future__ import annotations

import ipaddress
import os
import stat
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING, Self

from heavylift.coordinator.transport.frame import check_names
from heavylift.kernel.errors import ProtocolError

if TYPE_CHECKING:
    from cryptography import x509
    from cryptography.hazmat.primitives.asymmetric.ec import EllipticCurvePrivateKey


def library() -> CertificateLibrary:
    """Import the Python package `cryptography`; raises ProtocolError with the command that installs it."""
    try:
        return CertificateLibrary()
    except ImportError:
        raise ProtocolError(
            "runs over several hosts need the package 'cryptography': pip install 'heavylift[hosts]'"
        ) from None


class CertificateLibrary:
    """The functions of the package `cryptography` that heavylift uses; the package is imported on first use."""

    def __init__(self) -> None:
        from cryptography import x509
        from cryptography.exceptions import InvalidSignature
        from cryptography.hazmat.primitives import hashes, serialization
        from cryptography.hazmat.primitives.asymmetric import ec
        from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

        self.x509, self.ec, self.hashes, self.forms = x509, ec, hashes, serialization
        self.names, self.uses = NameOID, ExtendedKeyUsageOID
        self.invalid = (InvalidSignature, ValueError, TypeError)

    def x509_of(self, path: Path) -> x509.Certificate:
        """Read the certificate in a PEM file; raises ProtocolError if there is none."""
        try:
            return self.x509.load_pem_x509_certificate(path.read_bytes())
        except (OSError, ValueError):
            raise ProtocolError(f"{path} is not a valid certificate; delete it and create a new one") from None

    def key_of(self, path: Path) -> EllipticCurvePrivateKey:
        """Read the private key in a PEM file; raises ProtocolError if the file holds no elliptic-curve key."""
        try:
            key = self.forms.load_pem_private_key(path.read_bytes(), None)
        except (OSError, ValueError, TypeError):
            key = None
        if not isinstance(key, self.ec.EllipticCurvePrivateKey):
            raise ProtocolError(f"{path} is not a valid EC private key; delete it and create a new one")
        return key

    def common_name(self, certificate: x509.Certificate) -> str:
        """Return the common name of a certificate, which is the name of the process that owns it."""
        names = certificate.subject.get_attributes_for_oid(self.names.COMMON_NAME)
        return str(names[0].value) if names else ""

    def signed(self, certificate: x509.Certificate, by: x509.Certificate) -> bool:
        """Return whether `certificate` was signed with the key of the certificate `by`."""
        try:
            certificate.verify_directly_issued_by(by)
        except self.invalid:
            return False
        return True

    def pems(self, certificate: x509.Certificate, key: EllipticCurvePrivateKey) -> tuple[bytes, bytes]:
        """Return a certificate and its key in PEM form."""
        pem, plain = self.forms.Encoding.PEM, self.forms.NoEncryption()
        return certificate.public_bytes(pem), key.private_bytes(pem, self.forms.PrivateFormat.PKCS8, plain)

    def authority(self, name: str, days: float) -> tuple[x509.Certificate, EllipticCurvePrivateKey]:
        """Create a self-signed certificate authority and its key."""
        key = self.ec.generate_private_key(self.ec.SECP256R1())
        begun = self._begin(name, name, key, days).add_extension(self.x509.BasicConstraints(True, 0), critical=True)
        usage = dict.fromkeys(
            (
                "digital_signature",
                "content_commitment",
                "key_encipherment",
                "data_encipherment",
                "key_agreement",
                "encipher_only",
                "decipher_only",
            ),
            False,
        )
        begun = begun.add_extension(self.x509.KeyUsage(key_cert_sign=True, crl_sign=True, **usage), critical=True)
        known_by = self.x509.SubjectKeyIdentifier.from_public_key(key.public_key())
        return begun.add_extension(known_by, critical=False).sign(key, self.hashes.SHA256()), key

    def leaf(
        self, name: str, hosts: Sequence[str], days: float, signer: tuple[x509.Certificate, EllipticCurvePrivateKey]
    ) -> tuple[x509.Certificate, EllipticCurvePrivateKey]:
        """Create a certificate for one end of a connection, valid for these host names; return it and its private
        key."""
        authority, signing = signer
        key = self.ec.generate_private_key(self.ec.SECP256R1())
        use = self.uses
        begun = self._begin(name, self.common_name(authority), key, days)
        begun = begun.add_extension(self.x509.BasicConstraints(False, None), critical=True)
        begun = begun.add_extension(self.x509.SubjectAlternativeName([self._host(h) for h in hosts]), critical=False)
        begun = begun.add_extension(self.x509.ExtendedKeyUsage([use.SERVER_AUTH, use.CLIENT_AUTH]), critical=False)
        made_by = self.x509.AuthorityKeyIdentifier.from_issuer_public_key(signing.public_key())
        return begun.add_extension(made_by, critical=False).sign(signing, self.hashes.SHA256()), key

    def _begin(self, name: str, issuer: str, key: EllipticCurvePrivateKey, days: float) -> x509.CertificateBuilder:
        def called(word: str) -> x509.Name:
            name: x509.Name = self.x509.Name([self.x509.NameAttribute(self.names.COMMON_NAME, word)])
            return name

        now = datetime.now(UTC)
        return (
            self.x509.CertificateBuilder()
            .subject_name(called(name))
            .issuer_name(called(issuer))
            .public_key(key.public_key())
            .serial_number(self.x509.random_serial_number())
            .not_valid_before(now - timedelta(hours=1))  # clocks of hosts differ
            .not_valid_after(now + timedelta(days=days))
        )

    def _host(self, host: str) -> x509.GeneralName:
        try:
            return self.x509.IPAddress(ipaddress.ip_address(host))
        except ValueError:
            return self.x509.DNSName(host)


AUTHORITY, COORDINATOR = "yard", "coordinator"
HERE = ("localhost", "127.0.0.1", "::1")
AUTHORITY_days = 3650


@dataclass(frozen=True)
class Credentials:
    """Paths of the files that one end of a connection needs: the authority's certificate, its own certificate and its
    own key."""

    authority: Path
    certificate: Path
    key: Path

    @classmethod
    def load(cls, directory: Path, name: str) -> Self:
        """Find a process's credentials in a directory; raises ProtocolError unless they are valid now, its own, and
        readable only by the user."""
        found = cls(directory / f"{AUTHORITY}.pem", directory / f"{name}.pem", directory / f"{name}.key")
        for path in (found.authority, found.certificate, found.key):
            if not path.is_file():
                message = f"{path} is missing, it belongs to the certificates of '{name}'"
                raise ProtocolError(f"{message}; make them with 'heavylift certificates {directory} {name}'")
        if stat.S_IMODE(found.key.stat().st_mode) & 0o077:
            raise ProtocolError(f"{found.key} can be read by others; make it private: chmod 600 {found.key}")
        _check(found, name)
        return found


def _check(found: Credentials, name: str) -> None:
    use = library()
    own, authority = (use.x509_of(path) for path in (found.certificate, found.authority))
    for path, certificate in ((found.certificate, own), (found.authority, authority)):
        if not certificate.not_valid_before_utc <= datetime.now(UTC) <= certificate.not_valid_after_utc:
            since, until = certificate.not_valid_before_utc, certificate.not_valid_after_utc
            raise ProtocolError(f"{path} is valid from {since:%Y-%m-%d} to {until:%Y-%m-%d} only; create a new one")
    if (whose := use.common_name(own)) != name:
        raise ProtocolError(f"{found.certificate} was issued to '{whose}', not to '{name}'; copy the right one")
    if not use.signed(own, authority):
        raise ProtocolError(f"{found.certificate} was not signed by {found.authority}; take both from one directory")


def make_certificates(directory: Path, names: Sequence[str], hosts: Sequence[str] = (), days: int = 365) -> list[Path]:
    """Write the missing keys and certificates of the coordinator and of the named processes; return the new files.

    `hosts`: names or addresses at which other hosts reach the coordinator.
    """
    check_names([name for name in names if name != COORDINATOR], "process")
    if AUTHORITY in names:
        raise ProtocolError(f"process name '{AUTHORITY}' cannot be used: it is the name of the yard's own certificate")
    use = library()
    directory.mkdir(mode=0o700, parents=True, exist_ok=True)
    written: list[Path] = []

    def place(name: str) -> tuple[Path, Path]:
        return directory / f"{name}.pem", directory / f"{name}.key"

    def write(name: str, certificate: x509.Certificate, key: EllipticCurvePrivateKey) -> None:
        for path, data, mode in zip(place(name), use.pems(certificate, key), (0o644, 0o600), strict=True):
            with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), "wb") as file:
                file.write(data)
            written.append(path)

    if not any(path.exists() for path in place(AUTHORITY)):
        write(AUTHORITY, *use.authority(f"heavylift {AUTHORITY}", AUTHORITY_days))
    missing = [name for name in (COORDINATOR, *names) if not any(path.exists() for path in place(name))]
    if not missing:
        return written
    pem, key = place(AUTHORITY)
    if not (pem.is_file() and key.is_file()):
        raise ProtocolError(
            f"{directory} has only one of {AUTHORITY}.pem and {AUTHORITY}.key; create "
            "certificates in a directory that has both, or in an empty one"
        )
    signer = use.x509_of(pem), use.key_of(key)
    for name in missing:
        write(name, *use.leaf(name, (*HERE, *hosts) if name == COORDINATOR else (name,), days, signer))
    return written
