"""Attacks by local users: texts for terminals, cells, workbooks, viewers, workers.

An attack yields, for each of its tries, what was tried and whether it ended as SECURITY.md promises.
"""

from __future__ import annotations

import csv
import io
import os
import pickle
import re
import shlex
import socket
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Iterator
from pathlib import Path
from random import Random

from heavylift.coordinator.commands.common.app import app
from heavylift.coordinator.sweeps import dask_workers, sweep
from heavylift.kernel import HeavyliftError
from heavylift.nodes.scene import load
from heavylift.nodes.scene.text import row_names
from heavylift.nodes.scenes import bundled
from heavylift.recordings.format import FORMULAS
from heavylift.recordings.read.export import _csv_rows
from heavylift.recordings.render import FoxgloveServer
from heavylift.recordings.sheets import Sheet, words, workbook_of
from typer.main import get_command_name

Tries = Iterator[tuple[str, bool]]
HEAVYLIFT = str(Path(sys.executable).with_name("heavylift"))
PATIENCE_s = 120.0
STEERS = ("\x1b[2J", "\x1b]0;owned\x07", "\x9b31m", "\u202e", "\u2066", "\u200b", "\r", "\n", "\x85", "\u2028", "\x08")
FORGED = "verdict: green: forged"
NASTY = "".join(STEERS) + f"[green]x[/green]\n{FORGED}"
QUOTED = '"' + "".join(c if c.isprintable() else f"\\u{ord(c):04x}" for c in NASTY) + '"'

LINES = {  # of each command, about SCENE and RUN, or one that ends in a sentence
    "run": "SCENE -o again.mcap --in-process",
    "tradeoff": "SCENE --budget 1s",
    "gallery": "SCENE -o gallery",
    "schema": "",
    "export-fmu": "SCENE -o a.fmu",
    "trust": "",
    "sweep": "SCENE --vary x=1",
    "limits": "SCENE --of nothing",
    "command": "SCENE x",
    "info": "RUN",
    "plot": "RUN -o a.png",
    "view": "RUN -o a.html",
    "report": "RUN -o a.html",
    "compare": "RUN RUN",
    "export": "RUN -o a.csv",
    "recover": "RUN",
    "trace": "RUN",
    "replay": "RUN --speed 1000",
    "resume": "RUN",
    "branch": "RUN --at 1",
    "measured": "RUN SCENE",
    "certificates": "keys a",
    "doctor": "",
}


def commands() -> list[str]:
    """The names of all commands."""
    import heavylift.coordinator.commands  # noqa: F401 - makes them known

    return [x.name or get_command_name(getattr(x.callback, "__name__", "")) for x in app.registered_commands]


def steers(text: str) -> bool:
    """Whether lines that were printed steer a terminal, or hold a line that is not ours."""
    forged = FORGED in [line.strip() for line in text.split("\n")]
    return forged or not text.replace("\n", "").replace("\u00a0", "").isprintable()


def nasty_scene(folder: Path) -> Path:
    """A lift with stages whose names steer terminals."""
    path = folder / "nasty.yaml"
    text = bundled()["lift"].read_text()
    path.write_text(re.sub("stage: [a-z]+( [a-z]+)*", lambda _: f"stage: {QUOTED}", text, count=1))
    return path


def said(folder: Path, line: str) -> str:
    """All that a command prints where no terminal is."""
    words, nothing = [HEAVYLIFT, *shlex.split(line)], subprocess.DEVNULL
    done = subprocess.run(words, cwd=folder, stdin=nothing, capture_output=True, timeout=PATIENCE_s, check=False)
    return (done.stdout + done.stderr).decode(errors="surrogateescape")


def terminal(folder: Path, short: bool) -> Tries:
    """Every command hears of a scene, a recording and files whose names steer terminals."""
    scene, named = nasty_scene(folder), folder / "named.yaml"
    named.write_text(scene.read_text().replace("crane: {type", f"{QUOTED}: {{type"))
    yield "check names", not steers(said(folder, f"check {named}"))
    message = said(folder, f"run {scene} --set 'end=12 s' -o run.mcap --in-process")
    yield f"run a scene of nasty stages: {message}", "wrote run.mcap" in message and not steers(message)
    nastier = folder / "x\x1b[2J\u202e.yaml"
    nastier.write_text(scene.read_text().replace("mass:", "moss:", 1))
    yield "check a file of nasty name", not steers(said(folder, f"check {shlex.quote(str(nastier))}"))
    twofold = folder / f"x\n{FORGED}\n.mcap"
    twofold.write_bytes(b"no recording")
    yield "info of a file of two lines", not steers(said(folder, f"info {shlex.quote(str(twofold))}"))
    for name in ["check", "info"] if short else commands():
        line = LINES.get(name, "SCENE").replace("SCENE", str(scene)).replace("RUN", "run.mcap")
        yield name, not steers(said(folder, f"{name} {line}"))


def cells(folder: Path, short: bool) -> Tries:
    """Texts that a spreadsheet would run, in CSV and XLSX."""
    from openpyxl import load_workbook

    random = Random(1)
    for _ in range(50 if short else 2000):
        begin = random.choice(["", " ", "\t", "\n"]) + random.choice(FORMULAS)
        text = begin + random.choice(["cmd|' /C calc'!A0", 'HYPERLINK("x";"y")', "1+1", "SUM(1,2)", "2;=3", '"'])
        out = io.BytesIO()
        _csv_rows(out, [text, "b"], [[text, 1.0], ["a", text]])
        rows = csv.reader(io.StringIO(out.getvalue().decode(), newline=""))
        found = [x for row in rows for x in row]
        yield f"CSV {text!r}", len(found) == 6 and not any(x.lstrip()[:1] in FORMULAS for x in found)
    nasty = [f"{begin}1+1" for begin in FORMULAS]
    made = workbook_of(Sheet("=1+1", "=1+1", "", (words("a", nasty, [nasty, nasty], *nasty),)))
    for row in load_workbook(io.BytesIO(made)).worksheets[0].iter_rows():
        for place in row:
            yield f"XLSX {place.value!r}", place.data_type != "f"


def workbooks(folder: Path, short: bool) -> Tries:
    """Small workbooks that unpack to very much, and some that are none."""
    from openpyxl import Workbook

    book, out = Workbook(), io.BytesIO()
    book.active.append(["block", "mass [t]"])
    book.active.append(["B1", 3])
    book.save(out)
    entity = "".join(f'<!ENTITY a{i} "{f"&a{i - 1};" * 10 if i else "ha"}">' for i in range(12))
    bombs = {
        "texts": ("xl/sharedStrings.xml", "<sst>" + "<si/>" * 4_000_000 + "</sst>"),
        "long texts": ("xl/sharedStrings.xml", "<sst>" + "<si><t>abc</t></si>" * 2_000_000 + "</sst>"),
        "cells": ("xl/worksheets/sheet1.xml", "<worksheet><sheetData><row>" + "<c/>" * 3_000_000),
        "formats": ("xl/styles.xml", "<styleSheet><cellXfs>" + "<xf/>" * 500_000),
        "bytes": ("xl/worksheets/sheet1.xml", " " * (80 << 20)),
        "entities": ("xl/worksheets/sheet1.xml", f"<!DOCTYPE x [{entity}]><worksheet>&a11;</worksheet>"),
        "parts": ("", ""),
        "nothing": ("xl/workbook.xml", "<"),
    }
    for kind, (part, text) in bombs.items():
        made, old = io.BytesIO(), zipfile.ZipFile(io.BytesIO(out.getvalue()))
        with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as new:
            for name in old.namelist():
                if name != part:
                    new.writestr(name, old.read(name))
            if part:
                new.writestr(part, text)
            for number in range(0 if part else 2000):
                new.writestr(f"x{number}", "")
        yield f"workbook of many {kind}", _refused(folder, made.getvalue())


def _refused(folder: Path, data: bytes) -> bool:
    (folder / "bomb.xlsx").write_bytes(data)
    try:
        row_names(folder, "bomb.xlsx")
    except HeavyliftError as error:
        return str(error).count("\n") == 0
    return False


def viewers(folder: Path, short: bool) -> Tries:
    """Pages of the web and others knock at the websocket for viewers."""
    from websockets.exceptions import WebSocketException
    from websockets.sync.client import connect

    def served(url: str, origin: str | None, **headers: str) -> bool:
        try:
            with connect(url, origin=origin, subprotocols=["foxglove.sdk.v1"], additional_headers=headers) as line:  # type: ignore[arg-type, list-item]
                return "serverInfo" in str(line.recv(timeout=10))
        except WebSocketException:
            return False

    with FoxgloveServer("lift", 0) as server:
        address, _, word = server.url.rpartition("/")
        for origin in (None, "https://app.foxglove.dev", "http://localhost:8080", "file://"):
            yield f"origin {origin}", served(server.url, origin)
            for wrong in ("", "x", word[:-1], word + "x", f"../{word}", f"{word}/"):
                yield f"word {wrong!r} from {origin}", not served(f"{address}/{wrong}", origin)
        evil = [
            "https://evil.example",
            "null",
            "http://localhost.evil.example",
            "https://app.foxglove.dev.evil.example",
        ]
        for origin in [*evil, "http://127.0.0.1@evil.example", "https://xapp.foxglove.dev", ""]:
            yield f"origin {origin}", not served(server.url, origin) if origin else True
        port = server.url.split(":")[2].split("/")[0]
        yield "another address of this machine", not _open("127.0.0.2", int(port))


def _open(host: str, port: int) -> bool:
    with socket.socket() as line:
        return line.connect_ex((host, port)) == 0


WORKER = """
import os, pickle
from heavylift.coordinator.sweeps import variant
honest = variant.answered
class Code:
    def __init__(self, base=object): pass
    def __reduce__(self):
        return eval, ("open('MARK' + str(__import__('os').getpid()), 'w').close()",)
class Bad(Exception):
    __reduce__ = Code.__reduce__
def answered(task, one):
    from distributed import get_worker
    match one.number:
        case 0: return Code()
        case 1: raise Bad("x")
        case 2:
            evil = pickle.dumps(Code())
            get_worker().log_event("warn", {"message": evil, "category": evil})
        case 3: return b"\\xc1"
        case 4: return honest(task, one).replace(b"number\\x04", b"number\\x02")
        case 5: return [Code()]
    return honest(task, one)
variant.answered = answered
"""


def workers(folder: Path, short: bool) -> Tries:
    """A worker of dask answers with code, in a result, an error, a warning; with bytes; with the row of another."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    line = f"sweep pendulum --set 'end=1 s' --vary 'gravity=1..6 m/s2 by 1 m/s2' --scheduler {address}"
    for scheduler in [address, address.removeprefix("tcp://"), address.replace("tcp", "ws")][: 1 if short else 3]:
        message = said(folder, f"{line.replace(address, scheduler)} -o refused")
        yield f"{scheduler[:4]} without a word", "is not encrypted" in message and not (folder / "refused").exists()
    if short:
        return
    (folder / "worker.py").write_text(WORKER.replace("MARK", str(folder / "mark-")))
    dask, port = [sys.executable, "-m", "dask"], address.rpartition(":")[2]
    serve = [*dask, "scheduler", "--host", "tcp://127.0.0.1", "--port", port, "--no-dashboard"]
    work = [*dask, "worker", address, "--no-nanny", "--nthreads", "1", "--no-dashboard", "--preload", "worker.py"]
    none = subprocess.DEVNULL
    engine = [subprocess.Popen(line, cwd=folder, stdout=none, stderr=none) for line in (serve, work)]
    try:
        while not _open("127.0.0.1", int(port)):
            time.sleep(0.1)
        dask_workers.FETCH_s, dask_workers.SILENCE_s = 3.0, 15.0
        with dask_workers.dask_workers(address, folder, insecure=True) as crowd:
            scene = load("pendulum", ["end=1 s"])
            study = sweep(scene, ["gravity=1..6 m/s2 by 1 m/s2"], into=folder / "study", executor=crowd)
    finally:
        for process in engine:
            process.kill()
            process.wait()
    marks = [x.name for x in folder.glob("mark-*")]
    for kind in ("result", "error", "warning", "list"):
        yield f"code as {kind}", f"mark-{os.getpid()}" not in marks
    states = {number: row["status"] for number, row in study.rows.items()}
    yield f"what the worker answered is lost: {states}", all(states[n] == "lost" for n in (0, 1, 3, 4, 5))
    yield "the study ends", set(states) == set(range(6))


def pickles(folder: Path, short: bool) -> Tries:
    """Random pickles of callables are loaded where rows of workers come in."""
    for call in (os.system, os.getpid, eval, exec, subprocess.run, print, Path, tempfile.mkdtemp, open, __import__):
        for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
            data = pickle.dumps(call, protocol)
            with dask_workers.no_code:
                try:
                    pickle.loads(data)
                    yield f"{call}, protocol {protocol}", False
                except AttributeError:
                    yield f"{call}, protocol {protocol}", True
