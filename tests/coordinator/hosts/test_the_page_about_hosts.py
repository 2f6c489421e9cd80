"""Every command of coordinator/hosts/HOSTS.md does what the page says; addresses become those of this machine."""

import re
import shlex
from pathlib import Path

import pytest
from heavylift.nodes.scene import parse
from heavylift.recordings import Recording
from of_a_yard import ended, finish, free_port, start, until

PAGE = (Path(__file__).parents[3] / "coordinator/hosts/HOSTS.md").read_text()
BLOCKS = re.findall(r"```\w*\n(.*?)```", PAGE, re.S)
COMMANDS = [
    shlex.split(line, comments=True)[1:] for block in BLOCKS for line in block.splitlines() if line[:9] == "heavylift"
]


@pytest.mark.large
def test_each_command_for_one_host_on_the_hosts_page_gives_the_same_digest(tmp_path: Path, truth: str) -> None:
    alone = COMMANDS[:4]
    assert [command[2:4] for command in alone[1:3]] == [["--processes", "4"], ["--processes", "auto"]]
    for command in alone:
        assert finish(tmp_path, *command, "--force")[0] == 0
        assert Recording(tmp_path / "lift.mcap").result["digest"] == truth


@pytest.mark.large
def test_the_commands_printed_on_the_hosts_page_for_two_hosts_join_one_run(tmp_path: Path, truth: str) -> None:
    pytest.importorskip("cryptography", reason="no package 'cryptography': certificates cannot be made")
    port = str(free_port())
    made, run, node = (
        [word.replace("192.168.1.10", "127.0.0.1").replace("7447", port) for word in command]
        for command in COMMANDS[4:]
    )
    assert [command[0] for command in (made, run, node)] == ["certificates", "run", "node"]
    assert finish(tmp_path, *made)[0] == 0
    coordinator = start(tmp_path, *run)
    assert " ".join(node[:4]) in until(coordinator, "waiting for process yard-b")
    assert finish(tmp_path, *node)[0] == 0
    assert ended(coordinator)[0] == 0
    assert Recording(tmp_path / "lift.mcap").result["digest"] == truth


def test_the_scene_on_the_documentation_page_about_hosts_can_be_loaded() -> None:
    (placement,) = (block for block in BLOCKS if block.startswith("placement:"))
    loaded = parse(f"heavylift: 1\nname: lift\nextends: lift\n{placement}")
    assert loaded.facts.placement == {"crane": "yard-a", "block": "yard-a", "kernel": "yard-b"}
    assert loaded.facts.remote == ["yard-b"]
