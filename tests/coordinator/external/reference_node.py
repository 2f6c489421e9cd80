"""A station of the token ring (nodes/zoo) without heavylift, as WIRE.md tells: `python reference_node.py s1.ticket`."""

import json
import os
import struct
import sys
import time
import zlib
from pathlib import Path

import msgpack
import zenoh

WIRE, FOREVER, HEAD = 1, [2**63 - 1, 0], struct.Struct("<Q4sBIBB")
BLOCK, DELETE = zenoh.CongestionControl.BLOCK, zenoh.SampleKind.DELETE


def after(tag, wait, steps=1):
    return [tag[0] + wait, 0] if wait else [tag[0], tag[1] + steps]


class Station:  # holds what arrives together for `hold` [ns], then passes it on
    def __init__(self, name, parameters):
        self.name, self.hold, first = name, parameters["hold"], parameters["first"]
        self.tokens, self.next = ([first["number"]], [self.hold, 0]) if first else ([], FOREVER)

    def outputs(self):  # lambda: [t, k, model, port, index, type, payload]
        text = [msgpack.packb({"number": number}) for number in self.tokens]
        return [[*self.next, self.name, "out", i, "Token", payload] for i, payload in enumerate(text)]

    def transition(self, tag, bag):  # internal, external, or one after the other
        kept = [] if tag == self.next else self.tokens
        self.tokens = kept + [msgpack.unpackb(event[6])["number"] for event in bag]
        self.next = after(tag, self.hold) if bag else FOREVER

    def done(self, kept, gseq, until, echo, offered, inputs):  # steps 8 to 10 of PROTOCOL.md
        kept[:], stop, spoken = sorted(kept + inputs), until, []
        while (tag := min(self.next, kept[0][:2] if kept else FOREVER)) < stop:
            if tag == self.next:
                stop = min(stop, max(after(tag, 0), after(tag, *echo) if echo else FOREVER))
                spoken += [] if offered else self.outputs()
            offered, bag = False, [event for event in kept if event[:2] == tag]
            del kept[: len(bag)]
            self.transition(tag, bag)
        return ["done", gseq, stop, spoken, self.next, self.outputs(), self.next, b""]


ticket = json.loads(Path(sys.argv[1]).read_text())
if ticket["wire"] != WIRE:
    sys.exit(f"this program speaks wire {WIRE}, the run wire {ticket['wire']}")
run, process, epoch, node = ticket["run"], ticket["process"], ticket["epoch"], next(iter(ticket["nodes"]))
names, key, kept, number, heard = run.encode() + node.encode(), f"heavylift/{run}", [], 0, 0
auth = {"usrpwd": {"user": process, "password": ticket["password"]}}
at, client = {"endpoints": [f"unixsock-stream/{ticket['socket']}"]}, {"mode": "client", "transport": {"auth": auth}}
session = zenoh.open(zenoh.Config.from_json5(json.dumps({**client, "connect": at})))
out = session.declare_publisher(f"{key}/out/{process}/{node}", congestion_control=BLOCK)
inbox = session.declare_subscriber(f"{key}/in/{process}/*", zenoh.handlers.FifoChannel(4096))
hub = session.liveliness().declare_subscriber(f"{key}/alive/~hub", lambda x: x.kind == DELETE and os._exit(86))
while not out.matching_status.matching:
    time.sleep(0.001)
token = session.liveliness().declare_token(f"{key}/alive/{process}/{epoch}")
while True:
    frame = inbox.recv().payload.to_bytes()
    assert zlib.crc32(frame[4:]) == int.from_bytes(frame[:4], "little"), "damaged"
    assert HEAD.unpack_from(frame, 4)[:4] == (heard, b"HLF1", 0, epoch), "not the next message of this run"
    kind, *fields = msgpack.unpackb(frame[4 + HEAD.size + len(names) :])
    if kind == "welcome":
        station = Station(node, msgpack.unpackb(fields[1])["models"][node]["parameters"])
        offer = station.outputs()
        answer = ["hello", station.next, offer, station.next, {f"{node}.out": 0}, b"", f"wire {WIRE}"]
    elif kind == "grant":
        answer = station.done(kept, *fields)
    else:
        answer = ["bye"] if kind == "stop" else ["checkpoint", fields[0], b"", f"{node} keeps no state"]
    body = HEAD.pack(number, b"HLF1", 1, epoch, len(run), len(node)) + names + msgpack.packb(answer)
    out.put(zlib.crc32(body).to_bytes(4, "little") + body)
    heard, number = heard + 1, number + 1
    if kind == "stop":
        list(session.get(f"{key}/leave/{process}", timeout=2.0))  # answered when all that was sent is there
        sys.exit(session.close())
