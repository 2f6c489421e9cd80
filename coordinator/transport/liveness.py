"""The monitoring thread of a hub: which processes have joined, which are lost, and when a deadline has passed.

Zenoh's `recv` has no timeout, so this thread wakes it (20 checks a second: timeouts are rounded up to the next 0.05 s).
Its findings are queued as news for the receiving thread. A process is lost when the system reports its end, or when its
connection has ended and no reason is reported within GRACE_s; all its messages have arrived by then. Each incarnation
of a process has its own liveness token, alive/<process>/<epoch>; tokens of older ones are ignored.
"""

import queue
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

import zenoh
from heavylift.kernel.errors import ProtocolError

from .frame import FIRST_EPOCH, LAST_EPOCH

TICK_s = 0.05  # how often the thread looks
GRACE_s = 0.3  # how long a lost connection waits for the reason of its process's end


class News(NamedTuple):
    """Report to the thread that receives messages: a process has joined, or how it was `lost`."""

    process: str
    epoch: int  # its number among the processes of this name
    lost: str | None


class LivenessMonitor:
    """Monitor that detects which processes of a run have joined, left or died.

    `wake` interrupts the receiving thread; `connected` returns whether a process is connected.
    """

    def __init__(self, processes: Iterable[str], wake: Callable[[], None], connected: Callable[[str], bool]) -> None:
        self.epochs = dict.fromkeys(processes, FIRST_EPOCH)
        """The present incarnation of each process."""
        self.joined: set[str] = set()
        self.news: deque[News] = deque()
        self.deadline: float | None = None
        """When the receiving thread wants to be woken [monotonic s]."""
        self.failure: Exception | None = None
        """The exception that ended the thread, if any."""
        self._wake, self._connected = wake, connected
        self._deaths: Callable[[], Mapping[str, str]] = dict
        self._excused: set[str] = set()  # processes that may leave
        self._lost: dict[tuple[str, int], float] = {}  # since when
        self._reported: set[tuple[str, int]] = set()
        self._reports = 0
        self._bell: queue.SimpleQueue[tuple[str, int] | None] = queue.SimpleQueue()
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="hub lookout", daemon=True)

    def start(self) -> None:
        """Start the thread that monitors the processes."""
        self._thread.start()

    def close(self) -> None:
        """Stop monitoring."""
        self._closed.set()
        self.notice()
        self._thread.join(timeout=1.0)

    def token(self, sample: zenoh.Sample) -> None:
        """Handle a liveness token that has appeared or disappeared; called by Zenoh."""
        process, epoch = str(sample.key_expr).split("/")[-2:]
        present = self.epochs.get(process)
        if present is None or epoch != str(present):
            return
        if sample.kind == zenoh.SampleKind.DELETE:
            self._bell.put((process, present))
        else:
            self.joined.add(process)
            self._report(News(process, present, None))
            self.notice()

    def supervise(self, deaths: Callable[[], Mapping[str, str]]) -> None:
        """Set the function `deaths`, which returns for each ended process how it ended."""
        self._deaths = deaths

    def notice(self) -> None:
        """Make the monitoring thread check the processes at once."""
        self._bell.put(None)

    def hurry(self) -> None:
        """Wake the receiving thread at once if it waits with a deadline."""
        if self.deadline is not None:
            self.deadline = time.monotonic()
            self.notice()

    def excuse(self, *processes: str) -> None:
        """Let processes leave without counting them as lost."""
        self._excused.update(processes)

    def lost(self, process: str) -> bool:
        """Return whether the present process of this name was reported lost or has been allowed to leave."""
        return process in self._excused or (process, self.epochs[process]) in self._reported

    def renew(self, process: str) -> None:
        """Monitor the next process of this name instead of the present one."""
        if self.epochs[process] == LAST_EPOCH:
            raise ProtocolError(
                f"process {process} was replaced {LAST_EPOCH} times; this computer cannot keep it running"
            )
        self.epochs[process] += 1
        self.joined.discard(process)

    def _watch(self) -> None:
        try:
            self._look()
        except Exception as error:  # nobody would see it here, and the receiving thread would sleep for ever
            self.failure = error
            self._wake()

    def _look(self) -> None:
        woken: float | None = None
        count = 0
        while not self._closed.is_set():
            try:
                gone = self._bell.get(timeout=0.005 if self._lost else TICK_s)
                if gone is not None:
                    self._lost.setdefault(gone, time.monotonic())
            except queue.Empty:
                pass
            self._check_losses()
            deadline = self.deadline
            due = deadline is not None and deadline != woken and time.monotonic() >= deadline
            if due or count != self._reports:
                woken, count = deadline if due else woken, self._reports
                self._wake()

    def _check_losses(self) -> None:
        now, epochs = time.monotonic(), dict(self.epochs)
        deaths = {(process, epochs[process]): how for process, how in self._deaths().items()}
        for process, epoch in deaths:
            self._lost.setdefault((process, epoch), now)
        for known, since in list(self._lost.items()):
            process, epoch = known
            if process in self._excused or known in self._reported or epoch != epochs[process]:
                del self._lost[known]
            elif now - since > GRACE_s or (known in deaths and not self._connected(process)):
                self._reported.add(known)
                self._report(News(process, epoch, deaths.get(known, "it left the run")))

    def _report(self, news: News) -> None:
        self.news.append(news)
        self._reports += 1
