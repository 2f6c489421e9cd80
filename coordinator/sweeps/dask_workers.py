"""Workers of a dask scheduler, as an executor that no worker and no scheduler makes run code here.

Dask's client unpickles errors, warnings and, unless told otherwise, results, so whoever speaks to it could run code.
Rows need none of that: while such an executor is in use, this process unpickles no class or function, by an audit hook
of Python, which sees what any library unpickles.  All traffic is behind certificates, or said by name not to be.
"""

import logging
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from heavylift.coordinator.hosts.certificates import COORDINATOR, Credentials
from heavylift.kernel.errors import ProtocolError, extra

WORKERS_s = 30.0  # for the first worker of a scheduler to come
FETCH_s = 30.0  # for an answer that a worker says it has; dask itself would ask for ever
SILENCE_s = 900.0  # without an answer of anybody, after which none is waited for
HARMLESS = {("builtins", "bytes")}  # what dask says of the type of a row


class Unpickled(AttributeError):
    """Refused unpickling of code; an AttributeError, so that dask handles it like its own errors."""


class _Guard:
    """Refuses to unpickle code while it is entered, by a permanent audit hook."""

    def __init__(self) -> None:
        self.entered, self._hooked = 0, False

    def __enter__(self) -> None:
        if not self._hooked:
            sys.addaudithook(self._hear)
            self._hooked = True
        self.entered += 1

    def __exit__(self, *_: object) -> None:
        self.entered -= 1

    def _hear(self, event: str, details: tuple[Any, ...]) -> None:
        if self.entered and event == "pickle.find_class" and tuple(details) not in HARMLESS:
            raise Unpickled(f"{details} is not unpickled: rows of workers are data")


no_code = _Guard()
"""A context in which nothing that is unpickled in this process runs code."""


class _Answer:
    """A future of dask; its result is fetched once, with a timeout."""

    def __init__(self, future: Any, workers: "_Workers") -> None:
        self.cancel, self._future, self._workers = future.cancel, future, workers

    def done(self) -> bool:
        """Whether the result is available, or will never be."""
        return self._future.done() or time.monotonic() - self._workers.heard > SILENCE_s

    def exception(self) -> BaseException | None:
        """The error of the call, or None."""
        if not self._future.done():
            return ProtocolError(f"no worker has answered for {SILENCE_s:g} s")
        try:
            self._answer = self._future.result(timeout=FETCH_s)
            self._workers.heard = time.monotonic()
        except Exception as error:
            return error
        return None

    def result(self) -> object:
        """The result."""
        return self._answer


class _Workers(Executor):
    def __init__(self, client: Any) -> None:
        self._client, self.heard = client, time.monotonic()

    def submit(self, call: Callable[..., Any], /, *args: Any, **named: Any) -> Any:
        """Submit a call, as an executor does."""
        return _Answer(self._client.submit(call, *args, **named, pure=False), self)


@contextmanager
def dask_workers(scheduler: str, keys: Path, insecure: bool = False) -> Iterator[Executor]:
    """The workers of the scheduler at `tls://HOST:PORT`; `keys`: the directory of the yard's certificates.

    `insecure`: without certificates and encryption, where everybody on the network can read, and answer with any row.
    """
    secret = scheduler.startswith("tls://")
    if not secret and not insecure:
        raise ProtocolError(
            f"--scheduler '{scheduler}': is not encrypted, and anybody on the network could answer; give "
            "tls://HOST:PORT with certificates, or say --insecure-scheduler"
        )
    dask = extra("distributed", ProtocolError("--scheduler needs dask.distributed; install heavylift[sweep]"))
    logging.disable(logging.CRITICAL)  # dask quotes at length what it could not read
    secured = None
    if secret:
        own = Credentials.load(keys, COORDINATOR)
        secured = dask.Security(
            tls_ca_file=str(own.authority),
            tls_client_cert=str(own.certificate),
            tls_client_key=str(own.key),
            require_encryption=True,
        )
    with no_code:
        try:
            client = dask.Client(scheduler, security=secured, timeout=10, deserializers=["msgpack"])
        except (OSError, TimeoutError, ValueError, TypeError, AttributeError) as error:
            raise ProtocolError(
                f"--scheduler '{scheduler}': nobody answers there ({error}); start `dask scheduler`"
            ) from None
        with client:
            try:
                client.wait_for_workers(1, timeout=WORKERS_s)
            except TimeoutError:
                raise ProtocolError(
                    f"--scheduler '{scheduler}': it has no workers; start `dask worker {scheduler}`"
                ) from None
            yield _Workers(client)
