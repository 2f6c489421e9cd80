"""Who may join a run from another host: the conversation before a process is a part of the run.

    process -> coordinator   ASK     its name, heavylift's version, its host, and what it insists on: a run, a scene
    coordinator -> process   ANSWER  a ticket, or the sentence that says why not; the coordinator tells it, too

The answer decides nothing about rights: keys are guarded by the names in certificates (session.py). It is there
so that both sides say what is wrong, and so that a process learns the run's id and its nodes.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from threading import Lock
from typing import TYPE_CHECKING

import msgspec
import zenoh
from heavylift.kernel.errors import UNREADABLE
from zenoh.handlers import Callback

from ..participants.participant import version
from ..transport.keys import JOIN, key
from ..transport.link import JOIN_s
from ..transport.session import Ticket

if TYPE_CHECKING:
    from ..transport.hub import Hub

__all__ = ["Answer", "Ask", "Gate"]


class Ask(msgspec.Struct, frozen=True):
    """A process on another host wants to join; an empty `run` or `scene` insists on nothing."""

    process: str
    version: str
    host: str
    run: str = ""
    scene: str = ""


class Answer(msgspec.Struct, frozen=True):
    """A ticket without a password, or why there is none."""

    ticket: Ticket | None
    refusal: str = ""


class Gate:
    """Answers those who ask to join; `expects` the scene of this fingerprint, `say`s what it does."""

    def __init__(self, hub: Hub, session: zenoh.Session, scene: str, say: Callable[[str], None]) -> None:
        self.hosts: dict[str, str] = {}
        """Remote process -> the host from which it has joined."""
        self._hub, self._scene, self._say = hub, scene, say
        self._asked: dict[str, float] = {}
        self._lock = Lock()
        self._queryable = session.declare_queryable(key(JOIN, "*"), Callback(self._reply))

    def _reply(self, query: zenoh.Query) -> None:
        with self._lock:
            try:
                asked = msgspec.msgpack.decode(query.payload.to_bytes() if query.payload else b"", type=Ask)
            except UNREADABLE:
                self._say("somebody with a certificate of this yard asked to join in words of another program")
                return
            answer = self.answer(asked)
        told = f"process {asked.process} on host {asked.host}"
        self._say(f"{told} has joined" if answer.ticket else f"refused {told}: {answer.refusal}")
        query.reply(query.key_expr, msgspec.msgpack.encode(answer))

    def answer(self, asked: Ask) -> Answer:
        """A ticket for whom the run waits; a sentence for all others."""
        hub, name = self._hub, asked.process
        remote = hub.placement.remote
        if asked.version != version():
            why = f"it runs heavylift {asked.version}, the coordinator {version()}; install one version on all hosts"
        elif asked.run not in ("", hub.run):
            why = f"it insists on run {asked.run}, but this is run {hub.run}"
        elif asked.scene not in ("", self._scene):
            why = "its scene is not the one that is run; give both hosts the same file and the same settings"
        elif name not in hub.placement.processes:
            why = f"this run has no process '{name}'; it waits for {', '.join(sorted(remote))}"
        elif name not in remote:
            why = (
                f"process '{name}' runs on the coordinator's host; those of other hosts are {', '.join(sorted(remote))}"
            )
        elif self._taken(name):
            why = f"process '{name}' is there already, on host {self.hosts[name]}"
        else:
            self.hosts[name], self._asked[name] = asked.host, time.monotonic()
            return Answer(hub.ticket(name))
        return Answer(None, why)

    def free(self, process: str) -> None:
        """Who has joined as this process is lost: another one may."""
        self._asked.pop(process, None)

    def _taken(self, process: str) -> bool:
        """Whether somebody has joined as this process, or has just been given a ticket."""
        recently = time.monotonic() - self._asked.get(process, -JOIN_s) < JOIN_s
        return recently or self._hub.joined(process)
