"""The door of a run for processes on other hosts: an encrypted address where both sides show certificates.

A run without remote processes has no door. The coordinator opens one only where `--listen` says, and only
for `tls`: plain tcp would let anybody on the network take part and read along.
"""

from __future__ import annotations

import re
import socket
from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

import zenoh
from heavylift.coordinator.transport.hub import Hub
from heavylift.kernel.errors import ProtocolError

from .certificates import Credentials
from .join_handshake import JoinHandshake

ALL = ("0.0.0.0", "[::]")  # all interfaces of a host


@dataclass(frozen=True)
class RemoteListener:
    """`endpoint`: tls/HOST:PORT, where the coordinator listens or where a process connects to."""

    endpoint: str
    credentials: Credentials

    @classmethod
    def at(cls, endpoint: str, credentials: Credentials) -> Self:
        """The door of an endpoint as a user gives it."""
        protocol, slash, rest = endpoint.partition("/")
        if slash and protocol != "tls":
            raise ProtocolError(
                f"{endpoint}: hosts are connected by tls only, with certificates on both sides, so that nobody else "
                f"takes part or reads along; write tls/{rest}"
            )
        found = re.fullmatch(r"(\[[0-9A-Fa-f:.]+\]|[A-Za-z0-9.-]+):([0-9]{1,5})", rest)
        if not slash or not found or not 0 < int(found[2]) < 65536:
            raise ProtocolError(f"'{endpoint}' is no address, write tls/HOST:PORT, such as tls/192.168.1.10:7447")
        return cls(endpoint, credentials)

    @property
    def address(self) -> tuple[str, int]:
        """Host, without brackets, and port."""
        host, _, port = self.endpoint.removeprefix("tls/").rpartition(":")
        return host.strip("[]"), int(port)

    @property
    def seen_from_afar(self) -> str:
        """The endpoint that another host can connect to, where this one listens on all interfaces."""
        host, _, port = self.endpoint.removeprefix("tls/").rpartition(":")
        return f"tls/{socket.gethostname() if host in ALL else host}:{port}"

    def gate(self, hub: Hub, session: zenoh.Session, scene: str, say: Callable[[str], None]) -> JoinHandshake:
        """Begins to answer those who ask to join; arguments as of `JoinHandshake`."""
        return JoinHandshake(hub, session, scene, say)

    def listening(self) -> dict[str, object]:
        """Zenoh's settings of the coordinator's side."""
        own = self.credentials
        return {**self._both(), "listen_private_key": str(own.key), "listen_certificate": str(own.certificate)}

    def connecting(self) -> dict[str, object]:
        """Zenoh's settings of a process's side: the coordinator's certificate must name the host we connect to."""
        own = self.credentials
        shown = {"connect_private_key": str(own.key), "connect_certificate": str(own.certificate)}
        return {**self._both(), **shown, "verify_name_on_connect": True}

    def _both(self) -> dict[str, object]:
        trusted = str(self.credentials.authority)
        return {"root_ca_certificate": trusted, "enable_mtls": True, "close_link_on_expiration": True}
