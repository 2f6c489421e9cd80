"""The node's side of the protocol: runs one `Steppable` under grants. No input or output, no clock.

While tag = min(next, first input) < min(until, stop): lambda if next == tag, then one `advance`. A reaction to an
output can return after the shortest cycle: after an output at a tag, stop = max(succ(tag), tag + echo). Each input is
sent once; inputs not reached yet are kept, merged by tag with those of later grants. Events on ports without receivers
in other nodes are reported with the DONE, or with the FAIL if the models fail. A grant ends early after a number of
events or tags, so that no node works endlessly while others wait. The node checks its promises: an output earlier than
declared and an input earlier than its own past are fatal errors that name it.
"""

import traceback
from collections.abc import Callable, Iterable
from hashlib import blake2b
from heapq import heappop, heappush

import msgspec
from heavylift.kernel.description.user_code import raised
from heavylift.kernel.errors import HeavyliftError, ModelError, ProtocolError, out_of_memory
from heavylift.nodes.devs import FOREVER, AtomicResult, Event, Keepable, Steppable, Tag, after, encode, succ
from heavylift.nodes.devs.events import in_bytes

from .distance import plus
from .messages import AnyMessage, Bye, Checkpoint, Fail, Grant, GrantDone, Hello, StopRun, Welcome, name_of

_ENCODER = msgspec.msgpack.Encoder(enc_hook=in_bytes)
_KEPT = msgspec.msgpack.Decoder(tuple[Tag, bytes, Tag, list[Event], list[Event], bytes])
_BEGIN = Tag(0)
SPOKEN = TAGS = 256  # events and tags after which a grant ends
LONGEST = 20_000  # characters of a traceback that are sent, the last ones


def kept(state: bytes) -> tuple[Tag, bytes]:
    """Return the content of a checkpoint: the logical time up to which the node has processed events, and the model's
    snapshot."""
    found = _KEPT.decode(state)
    return found[2], found[5]


class Node:
    """One node of the protocol: answers each message; `finish(end)` returns what the model still waits for, or ""."""

    def __init__(
        self, name: str, model: Steppable, finish: Callable[[Tag], str] = lambda end: "", samples: bool = False,
        hashed: bool = True,
    ) -> None:  # fmt: skip
        """`samples`: the model publishes its progress during its work, so the node ends a grant at the first output;
        `hashed`: each DONE carries a hash of what was done."""
        self._samples, self._hashed = samples, hashed
        self.name, self.model, self.epoch, self._finish = name, model, 0, finish
        self._last, self._hash = Tag(-1), b""
        self._done: GrantDone | None = None
        self._gseq, self._quiet = 0, FOREVER
        self._kept: list[Event] = []  # heap of inputs that it has not reached
        self._spoken: list[Event] = []  # under the present grant
        self._offer: list[Event] = []  # what it says at its next tag unless an input comes before
        self.cause: BaseException | None = None
        self.steps = 0
        """Number of logical times processed, including replayed ones; shows the progress of the node."""

    def hello(self, declaration: bytes = b"", version: str = "", scene: str = "") -> Hello | Fail:
        """Start the model, and return a HELLO with this declaration, or a FAIL."""
        try:
            self.model.start()
            tag, offer, self._quiet = self._present()
        except Exception as error:
            return self.failure(error)
        return Hello(tag, offer, self._quiet, dict(self.model.lookahead), declaration, version, scene)

    def handle(self, message: AnyMessage) -> GrantDone | Checkpoint | Fail | Bye | None:
        """Return the answer to a message of the coordinator; None if there is none."""
        match message:
            case Grant():
                if self._done is not None and message.gseq == self._done.gseq:
                    return self._done
                if message.gseq != self._gseq + 1:
                    raise ProtocolError(f"{self.name} got GRANT {message.gseq} after GRANT {self._gseq}")
                self._gseq = message.gseq
                try:
                    self._done = self._run(message)
                except Exception as error:
                    spoken = sorted(self._spoken + self.model.among())
                    last = max([self._last, *(event.tag for event in spoken[-1:])])
                    return self.failure(error, last, spoken)
                return self._done
            case Checkpoint():
                try:
                    return self._resume(message) if message.state else self._checkpoint()
                except Exception as error:
                    return self.failure(error, max(self._last, _BEGIN))
            case StopRun():
                try:
                    return Bye(self._finish(message.end), slack=self.model.slack, results=self._results(message))
                except Exception as error:
                    return self.failure(error, max(self._last, _BEGIN))
            case Welcome():
                self.epoch = message.epoch
                return None
        raise ProtocolError(f"{self.name} does not accept the message {name_of(message)}")

    @property
    def first(self) -> Tag:
        """The earliest pending logical time of the node: that of its model, or of an input not yet processed."""
        return min(self.model.next_time, self._kept[0].tag if self._kept else FOREVER)

    def _run(self, grant: Grant) -> GrantDone:
        model, kept, stop = self.model, self._kept, grant.until
        for event in grant.inputs:
            heappush(kept, event)
        links: list[object] = []
        self._spoken = spoken = []
        mixed, offered = False, grant.committed
        heard = first = kept[0].tag if kept else FOREVER
        due, last = model.next_time, self.steps + TAGS
        own = succ(due) if offered else self._quiet
        while (tag := first if first < due else due) < stop:
            if tag <= self._last:
                event = kept[0]
                raise ModelError(
                    f"{self.name} at {self._last}: message from {event.source}.{event.port} is late: due at {tag}"
                )
            bag = []
            while first == tag:
                bag.append(heappop(kept))
                first = kept[0].tag if kept else FOREVER
            outputs = [] if tag != due else model.outputs() if links else self._offer
            if outputs:
                stop = min(stop, succ(tag) if self._samples else max(succ(tag), plus(tag, grant.echo)))
                if not offered:
                    if tag < own:
                        self._check(outputs, own, heard)
                    spoken += outputs
            offered, self._last = False, tag
            self.steps += 1
            if len(spoken) >= SPOKEN or self.steps == last:
                stop = min(stop, succ(tag))
            model.advance(tag, bag, min(stop, first))
            if among := model.among():
                spoken += among
                mixed = True
            due = model.next_time
            links += (tag, bag, outputs, due)
        if links and self._hashed:
            self._hash = blake2b(_ENCODER.encode((self._hash, links)), digest_size=16).digest()
        if mixed:
            spoken.sort()
        due, offer, self._quiet = self._present()
        return GrantDone(grant.gseq, stop, spoken, due, offer, self._quiet, self._hash, model.last)

    def _checkpoint(self) -> Checkpoint:
        """Return the state that determines the next answer, together with the last DONE, by which a replacement is
        verified."""
        if not isinstance(self.model, Keepable) or self._done is None:
            return Checkpoint(self._gseq, why=f"{self.name} has a model whose state cannot be saved")
        try:
            model = self.model.snapshot()
        except HeavyliftError as error:
            return Checkpoint(self._gseq, why=str(error))
        text = self._done.reached, self._done.spoken
        return Checkpoint(self._gseq, _ENCODER.encode((self._last, self._hash, *text, sorted(self._kept), model)))

    def _resume(self, checkpoint: Checkpoint) -> GrantDone:
        assert isinstance(self.model, Keepable), "it has given a checkpoint"
        self._last, self._hash, reached, spoken, self._kept, model = _KEPT.decode(checkpoint.state)
        self.model.restore(model)
        self._gseq = checkpoint.gseq
        due, offer, self._quiet = self._present()
        self._done = GrantDone(checkpoint.gseq, reached, spoken, due, offer, self._quiet, self._hash, self.model.last)
        return self._done

    def _results(self, stop: StopRun) -> list[AtomicResult]:
        """Return the results of the models; none for an aborted run."""
        results = {} if stop.why else self.model.results(stop.end)
        return [AtomicResult(path, type(value).__name__, encode(value)) for path, value in results.items()]

    def _present(self) -> tuple[Tag, list[Event], Tag]:
        """Compute the next logical time, the offer and `quiet` of the model."""
        due = self.model.next_time
        self._offer = self.model.outputs() if due < FOREVER else []
        return due, self._offer, self.model.quiet

    def _check(self, text: list[Event], own: Tag, heard: Tag) -> None:
        for event in text:
            declared = min(own, after(heard, self.model.lookahead.get(f"{event.source}.{event.port}", 0)))
            if event.tag < declared:
                raise ModelError(
                    f"{self.name} at {event.tag}: output on port {event.port} before {declared}, the earliest "
                    "time that its declared lookahead allows; declare a shorter lookahead"
                )

    def failure(self, error: Exception, tag: Tag = _BEGIN, spoken: Iterable[Event] = ()) -> Fail:
        """Return the FAIL message of the node, and store the exception of the model in `cause`."""
        self.cause = error.__cause__ if isinstance(error, HeavyliftError) else error
        return failure(self.name, error, tag, spoken)


def failure(name: str, error: Exception, tag: Tag = _BEGIN, spoken: Iterable[Event] = ()) -> Fail:
    """Return the FAIL message of a node. Raises MemoryError if memory ran out outside of model code, which ends the
    process."""
    if out_of_memory(error) and not isinstance(error, ModelError):
        raise MemoryError from error
    sentence = str(error) if isinstance(error, HeavyliftError) else f"{name} at {tag}: {raised(error)}"
    text = "".join(traceback.format_exception(error))[-LONGEST:]
    return Fail(tag, name, sentence, text.encode(errors="backslashreplace").decode(), list(spoken))
