"""What somebody does who waits for the ticket of a run."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

PATIENCE_s = 60.0
Guest = Callable[[Path], object]


@pytest.fixture
def guest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[Guest], object]:
    """Does something with `s1.ticket` in another thread as soon as a run writes it."""
    monkeypatch.chdir(tmp_path)

    @contextmanager
    def waiting(do: Guest, name: str = "s1.ticket") -> Iterator[None]:
        def wait() -> None:
            deadline = time.monotonic() + PATIENCE_s
            while not (tmp_path / name).exists() and time.monotonic() < deadline:
                time.sleep(0.01)
            do(tmp_path / name)

        thread = threading.Thread(target=wait)
        thread.start()
        yield
        thread.join(PATIENCE_s)

    return waiting
