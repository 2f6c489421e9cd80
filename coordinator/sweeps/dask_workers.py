"""Workers of a dask scheduler as an executor; neither workers nor scheduler can make this process run code.

Dask's client unpickles errors, warnings and by default results, so anybody who can send to it could run code. Rows need
no pickles: while such an executor is in use, this process refuses to unpickle classes and functions, by an audit hook
of Python, which covers unpickling by any library. Traffic is protected by certificates unless the user explicitly
allows it unprotected.
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
POLL_s = 0.02  # between two looks for an answer
SILENCE_s = 900.0  # without an answer of anybody, after which none is waited for
HARMLESS = {("builtins", "bytes")}  # what dask says of the type of a row


class Unpickled(AttributeError):
    """Raised when a worker's answer contains pickled code, which is never loaded."""


class _Guard:
    """Guard that refuses to unpickle code while it is active, by a permanent audit hook."""

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
            raise Unpickled(f"{details} was not unpickled: workers may return only data")


no_code = _Guard()
"""A context in which nothing that is unpickled in this process runs code."""


class _Answer:
    """A future of dask, whose result is fetched once, with a timeout."""

    def __init__(self, future: Any, workers: "_Workers") -> None:
        self.cancel, self._future, self._workers = future.cancel, future, workers
        self._answer: object = None

    def done(self) -> bool:
        """Return whether the call has ended or its result is no longer expected."""
        return self._future.done() or time.monotonic() - self._workers.heard > SILENCE_s

    def exception(self) -> BaseException | None:
        """Return the error of the call, or None."""
        if not self._future.done():
            return ProtocolError(f"no worker of the scheduler has answered for {SILENCE_s:g} s; start one")
        if self._answer is not None:
            return None
        try:
            self._answer = self._future.result(timeout=FETCH_s)
            self._workers.heard = time.monotonic()
        except Exception as error:
            return error
        return None

    def result(self) -> object:
        """Wait for the result of the call and return it; raises the error of the call."""
        while not self.done():
            time.sleep(POLL_s)
        if error := self.exception():
            raise error
        return self._answer


class _Workers(Executor):
    def __init__(self, client: Any) -> None:
        self._client, self.heard = client, time.monotonic()

    def submit(self, call: Callable[..., Any], /, *args: Any, **named: Any) -> Any:
        """Submit a call to the dask workers; return its future."""
        return _Answer(self._client.submit(call, *args, **named, pure=False), self)


@contextmanager
def dask_workers(scheduler: str, keys: Path, insecure: bool = False) -> Iterator[Executor]:
    """Yield an executor that uses the workers of the scheduler at `tls://HOST:PORT`; `keys`: directory with the yard's
    certificates.

    `insecure`: without certificates and encryption; anybody on the network can then read rows and forge them.
    """
    secret = scheduler.startswith("tls://")
    if not secret and not insecure:
        raise ProtocolError(
            f"--scheduler '{scheduler}' is not encrypted, and anybody on the network could answer; give "
            "tls://HOST:PORT with certificates, or the option --insecure-scheduler"
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
                f"--scheduler '{scheduler}': no scheduler answers at this address ({error}); start `dask scheduler`"
            ) from None
        with client:
            try:
                client.wait_for_workers(1, timeout=WORKERS_s)
            except TimeoutError:
                raise ProtocolError(
                    f"--scheduler '{scheduler}': it has no workers; start `dask worker {scheduler}`"
                ) from None
            yield _Workers(client)
