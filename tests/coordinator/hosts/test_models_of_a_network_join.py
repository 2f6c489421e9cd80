"""`heavylift devs` over several hosts: models placed in a process that somebody starts there, the digest unchanged."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from of_a_yard import finish, free_port, start, until

RING = """
from heavylift.nodes.zoo.token_ring import ring

def build():
    return ring(stations=4, tokens=2, hold=5_000_000)
"""


@pytest.mark.large
def test_each_model_runs_on_the_host_on_which_it_is_placed(tmp_path: Path, keys: Path) -> None:
    for host in ("here", "there"):
        (tmp_path / host).mkdir()
        (tmp_path / host / "rings.py").write_text(RING)
    devs = ["devs", "rings:build", "--until", "21 ms", "--json"]
    alone = start(tmp_path / "here", *devs, "--in-process")
    truth = json.loads(alone.communicate()[0])["digest"]
    endpoint = f"tls/127.0.0.1:{free_port()}"
    afar = ["--place", "s1,s3=yard-b", "--remote", "yard-b", "--listen", endpoint, "--certificates", keys]
    run = start(tmp_path / "here", *devs, *afar)
    until(run, "waiting for process yard-b")
    code, text = finish(tmp_path / "there", "node", "yard-b", "--connect", endpoint, "--certificates", keys)
    assert (code, "that you have not trusted" in text) == (1, True), text
    run.communicate(timeout=60)
    run = start(tmp_path / "here", *devs, *afar)
    until(run, "waiting for process yard-b")
    joining = ["node", "yard-b", "--connect", endpoint, "--certificates", keys]
    code, text = finish(tmp_path / "there", *joining, "--allow-code", "rings.py")
    assert code == 0, text
    assert text.startswith("joined run ")
    assert " with s1, s3\n" in text
    out, _ = run.communicate(timeout=60)
    assert json.loads(out)["digest"] == truth


def test_an_impossible_placement_of_models_on_hosts_is_refused_before_any_process_starts(tmp_path: Path) -> None:
    (tmp_path / "rings.py").write_text(RING)
    for words, message in {
        "--place s9=yard": "--place 's9=yard': there is no node 's9'; the nodes are s0, s1, s2, s3",
        "--processes x": "Invalid value for '--processes': 'x' is not a number of processes; give an integer or auto",
        "--remote yard": "process yard runs on another host, say where it can reach this one: --listen tls/ADDRESS:7447"
        "",
    }.items():
        code, text = finish(tmp_path, "devs", "rings:build", *words.split())
        assert code in (1, 2)
        assert text == f"heavylift: {message}\n"
