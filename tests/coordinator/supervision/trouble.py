"""Trouble for the processes of a run at chosen points: when the n-th message is sent to a node."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, ClassVar
from unittest import mock

from heavylift.coordinator.run import ModelRun, RunObserver, conversation, run_models
from heavylift.coordinator.supervision import Succession, failover as succession

MODELS = str(Path(__file__).with_name("doomed_models.py"))
Act = Callable[[Succession], None]


class Notes(RunObserver):
    """What a user would be reported."""

    def __init__(self) -> None:
        self.notes: list[str] = []

    def say(self, sentence: str) -> None:
        self.notes.append(sentence)


class Troubled(Succession):
    """Acts when the conversation sends its n-th message, and counts what processes are reported."""

    plan: ClassVar[dict[int, Act]] = {}
    deadline: ClassVar[float | None] = None
    last: ClassVar[Troubled]

    def __init__(self, nodes: Any, crew: Any, listener: Any, deadline: float) -> None:
        super().__init__(nodes, crew, listener, Troubled.deadline or deadline)
        self.sent, self.said = 0, 0
        Troubled.last = self

    def send(self, node: str, payload: bytes) -> None:
        super().send(node, payload)
        self.sent += 1
        if self.sent in self.plan:
            self.plan[self.sent](self)

    def _report(self, node: str, life: Any, payload: bytes) -> None:
        self.said += 1
        super()._report(node, life, payload)


def pid(hub: Succession, process: str) -> int:
    """The process, as soon as it is known."""
    while (found := hub._crew.pid(process)) is None:
        pass
    return found


def strike(*processes: str, number: int = signal.SIGKILL) -> Act:
    """Send a signal to these processes; one that has said all it had to say may be gone."""

    def act(hub: Succession) -> None:
        for process in processes:
            with suppress(ProcessLookupError):
                os.kill(pid(hub, process), number)

    return act


def keeper(number: int = signal.SIGKILL) -> Act:
    """Send a signal to the process that keeps all others."""
    return lambda hub: os.kill(hub._crew._keeper.pid, number)


def both(*acts: Act) -> Act:
    """One after the other."""

    def act(hub: Succession) -> None:
        for each in acts:
            each(hub)

    return act


@contextmanager
def trouble(plan: dict[int, Act], deadline: float | None = None, **settings: float) -> Iterator[None]:
    """Runs inside meet this trouble; `settings` of `succession` may be others."""
    with (
        mock.patch.object(conversation, "Succession", Troubled),
        mock.patch.multiple(Troubled, plan=plan, deadline=deadline),
        mock.patch.multiple(succession, **{"KEEP_s": succession.KEEP_s, **settings}),
    ):
        yield


def play(
    plan: dict[int, Act],
    build: str = "build",
    deadline: float | None = None,
    places: Sequence[str] = (),
    **settings: float,
) -> tuple[ModelRun, list[str]]:
    """The ring of runners in trouble, and the notes about it."""
    notes = Notes()
    with trouble(plan, deadline, **settings):
        return run_models(f"{MODELS}:{build}", watch=notes, places=places), notes.notes
