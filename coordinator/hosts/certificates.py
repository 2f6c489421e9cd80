"""Keys and certificates of a yard: who may take part in a run from another host.

One authority per yard (`yard.pem`, its key stays at home) signs a certificate for the coordinator and one for each
process that runs elsewhere; its common name is that process's name. EC P-256, a subject alternative name (RFC 5280),
extendedKeyUsage serverAuth and clientAuth: both ends of a connection show a certificate and check the other's.

    yard.pem yard.key    coordinator.pem coordinator.key    NAME.pem NAME.key    keys for their owner only (0600)
A process on another host needs three of them: yard.pem, NAME.pem, NAME.key.
"""

from __future__ import annotations

import os
import stat
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Self

from heavylift.coordinator.transport.keys import check_names
from heavylift.kernel.errors import ProtocolError

from .x509 import library

if TYPE_CHECKING:
    from cryptography import x509
    from cryptography.hazmat.primitives.asymmetric.ec import EllipticCurvePrivateKey

AUTHORITY, COORDINATOR = "yard", "coordinator"
HERE = ("localhost", "127.0.0.1", "::1")
AUTHORITY_days = 3650


@dataclass(frozen=True)
class Credentials:
    """The files by which one end of a connection shows who it is, and whom it trusts."""

    authority: Path
    certificate: Path
    key: Path

    @classmethod
    def load(cls, directory: Path, name: str) -> Self:
        """Those of a name, checked: all there, valid today, made for this name by this yard, the key private."""
        found = cls(directory / f"{AUTHORITY}.pem", directory / f"{name}.pem", directory / f"{name}.key")
        for path in (found.authority, found.certificate, found.key):
            if not path.is_file():
                told = f"{path} is missing, it belongs to the certificates of '{name}'"
                raise ProtocolError(f"{told}; make them with 'heavylift certificates {directory} {name}'")
        if stat.S_IMODE(found.key.stat().st_mode) & 0o077:
            raise ProtocolError(f"{found.key} can be read by others, make it private: chmod 600 {found.key}")
        _judge(found, name)
        return found


def _judge(found: Credentials, name: str) -> None:
    use = library()
    own, authority = (use.x509_of(path) for path in (found.certificate, found.authority))
    for path, certificate in ((found.certificate, own), (found.authority, authority)):
        if not certificate.not_valid_before_utc <= datetime.now(UTC) <= certificate.not_valid_after_utc:
            since, until = certificate.not_valid_before_utc, certificate.not_valid_after_utc
            raise ProtocolError(f"{path} is valid from {since:%Y-%m-%d} to {until:%Y-%m-%d} only, make a new one")
    if (whose := use.common_name(own)) != name:
        raise ProtocolError(f"{found.certificate} was made for '{whose}' and not for '{name}'")
    if not use.signed(own, authority):
        raise ProtocolError(f"{found.certificate} was not made by the yard of {found.authority}, use one directory")


def make_certificates(directory: Path, names: Sequence[str], hosts: Sequence[str] = (), days: int = 365) -> list[Path]:
    """Write what is missing in the directory for the coordinator and these processes; returns the new files.

    `hosts`: names or addresses by which other hosts reach the coordinator. What is there already is kept.
    """
    check_names([name for name in names if name != COORDINATOR], "process")
    if AUTHORITY in names:
        raise ProtocolError(f"process name '{AUTHORITY}' cannot be used, it is the name of the yard's own certificate")
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
            f"{directory} has {AUTHORITY}.pem without {AUTHORITY}.key or the other way round; "
            "make the certificates where both are, or begin in an empty directory"
        )
    signer = use.x509_of(pem), use.key_of(key)
    for name in missing:
        write(name, *use.leaf(name, (*HERE, *hosts) if name == COORDINATOR else (name,), days, signer))
    return written
