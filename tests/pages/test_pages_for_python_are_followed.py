"""The code on the pages about Python and studies runs and gives the results shown."""

from __future__ import annotations

import os
import re
import shlex
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest
from notebook import NOTEBOOK, PAGE, notebook
from page_blocks import ROOT, blocks, follow
from pyarrow import parquet

STUDIES = "coordinator/sweeps/SWEEPS.md"


@pytest.mark.large
def test_the_code_on_the_documentation_page_about_python_can_be_executed(tmp_path: Path, capfd, monkeypatch) -> None:
    pytest.importorskip("pinocchio")
    assert follow("coordinator/run/PYTHON.md", tmp_path, capfd, monkeypatch) == 9


def test_the_python_notebook_has_the_content_of_its_page() -> None:
    assert NOTEBOOK.read_text() == notebook(PAGE.read_text()), "run python tests/pages/notebook.py"


@pytest.mark.large
def test_the_code_on_the_documentation_page_about_studies_can_be_executed(tmp_path: Path, capfd, monkeypatch) -> None:
    monkeypatch.setattr("page_blocks.blocks", lambda page: [x for x in blocks(page) if "dask scheduler" not in x[1]])
    assert follow(STUDIES, tmp_path, capfd, monkeypatch) == 3


YARD = """
heavylift yard: 1
start: 2027-01-04
resources: {crew: 1}
blocks: {from: blocks.csv}
steps: {weld: {takes: uniform 4 h 8 h, needs: {crew: 1}}}
"""


@pytest.mark.large
def test_dask_workers_with_certificates_run_a_study(tmp_path: Path, monkeypatch) -> None:
    pytest.importorskip("distributed", reason="no package 'distributed': no scheduler")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = str(free.getsockname()[1])
    (text,) = (text for _, text in blocks(STUDIES) if "dask scheduler" in text)
    lines = text.replace("192.168.1.10", "127.0.0.1").replace("8786", port).splitlines()
    commands = [shlex.split(re.sub("^dask", f"{sys.executable} -m dask", line)) for line in lines]
    certificates, scheduler, worker, sweep = commands
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}:{os.environ['PATH']}")
    monkeypatch.chdir(tmp_path)
    subprocess.run(certificates, check=True, timeout=60)
    Path("yard.yaml").write_text(YARD)
    Path("blocks.csv").write_text("block\nA\nB\nC\n")
    yard = [sweep[0], *shlex.split("sweep yard.yaml --vary 'resources.crew={1, 2}' --sample 4 --json -o answers")]
    workers = sweep[sweep.index("--scheduler") :][:2]
    engine = [subprocess.Popen(command, stderr=subprocess.DEVNULL) for command in (scheduler, worker)]
    try:
        _listening(int(port))
        done = subprocess.run(sweep, capture_output=True, text=True, timeout=120)
        there = subprocess.run([*yard, *workers], capture_output=True, text=True, timeout=120)
    finally:
        for process in engine:
            process.send_signal(signal.SIGTERM)
        for process in engine:
            process.wait(timeout=60)
    assert done.returncode == 0, done.stderr
    here = subprocess.run(yard, capture_output=True, text=True, timeout=120)
    assert (there.returncode, there.stderr) == (here.returncode, here.stderr) == (0, here.stderr)
    assert there.stdout == here.stdout
    assert "3 variants of pendulum: 3 done" in done.stdout
    assert "the same digest again" in done.stdout
    processes = {row["process"] for row in parquet.read_table("study/rows.parquet").to_pylist()}
    assert len(processes) == 1
    assert os.getpid() not in processes


def _listening(port: int) -> None:
    for _ in range(300):
        with socket.socket() as line:
            if line.connect_ex(("127.0.0.1", port)) == 0:
                return
        time.sleep(0.1)
    raise AssertionError("the scheduler does not listen")


def test_the_readme_links_to_the_page_about_studies() -> None:
    assert "SWEEPS.md" in (ROOT / "README.md").read_text()
