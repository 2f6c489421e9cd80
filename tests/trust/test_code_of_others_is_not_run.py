"""Scenes, recordings and coordinators are data: Python that they name runs from folders that the user has trusted."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from commands import Command, law
from heavylift.coordinator.participants import Participant, parts
from heavylift.coordinator.protocol import messages as m

COMMANDS = (
    "check rail.yaml",
    "tree rail.yaml",
    "equations rail.yaml",
    "statics rail.yaml",
    "modes rail.yaml",
    "run rail.yaml",
    "run rail.yaml --in-process",
    "gallery rail.yaml",
    "tradeoff rail.yaml",
    "node east --connect tls/127.0.0.1:7447 --scene rail.yaml",
)


@pytest.mark.parametrize("line", COMMANDS)
def test_no_command_runs_untrusted_code_named_in_a_scene(heavylift: Command, tmp_path: Path, line: str) -> None:
    law(tmp_path)
    before = {*tmp_path.iterdir()}
    code, text = heavylift(*line.split())
    assert code == 1
    assert "rail.yaml:10:5: " in text
    assert text.split("\n")[0].endswith(f"; read it, then type: heavylift trust {tmp_path}")
    assert {*tmp_path.iterdir()} == before


@pytest.mark.parametrize("model", ["mine.py:push", "mine.fmu"])
def test_no_command_runs_an_untrusted_model_named_in_a_scene(heavylift: Command, tmp_path: Path, model: str) -> None:
    law(tmp_path)
    (tmp_path / "mine.fmu").write_bytes(b"no archive")
    models = f"models: {{own: {{model: '{model}', period: 1 s}}}}\n"
    text = (tmp_path / "rail.yaml").read_text().partition("  forces:")[0] + models
    (tmp_path / "rail.yaml").write_text(text)
    before = {*tmp_path.iterdir()}
    for line in ("check rail.yaml", "tree rail.yaml", "run rail.yaml", "run rail.yaml --in-process"):
        code, answer = heavylift(*line.split())
        assert (code, answer[:16]) == (1, "rail.yaml:9:24: ")
        assert answer.split("\n")[0].endswith(f"; read it, then type: heavylift trust {tmp_path}")
    assert {*tmp_path.iterdir()} == before


def test_the_trust_command_can_add_list_and_remove_trusted_folders(heavylift: Command, tmp_path: Path) -> None:
    scene = law(tmp_path / "mine")
    assert heavylift("trust", tmp_path / "mine")[0] == 0
    assert heavylift("trust") == (0, f"{tmp_path / 'mine'}\n")
    assert heavylift("check", scene)[0] == 0
    assert heavylift("trust", "mine/../mine", "--withdraw")[0] == 0
    assert heavylift("trust", "--list") == (0, "")
    assert heavylift("check", scene)[0] == 1
    assert heavylift("trust", "mine", "--withdraw")[0] == 1
    kept = tmp_path / "configuration" / "heavylift" / "trusted-folders"
    assert (kept.stat().st_mode & 0o777, kept.parent.stat().st_mode & 0o777) == (0o600, 0o700)


def test_the_option_allow_code_permits_untrusted_code_for_one_command(heavylift: Command, tmp_path: Path) -> None:
    law(tmp_path)
    assert heavylift("check", "rail.yaml", "--allow-code", "mine.py")[0] == 0
    assert heavylift("check", "rail.yaml", "--allow-code", ".")[0] == 0
    assert heavylift("check", "rail.yaml")[0] == 1
    assert heavylift("check", "rail.yaml", "--set", "mechanism.forces.own.function=mine.py:push")[0] == 0
    assert heavylift("check", "rail.yaml", "--set", "mechanism.forces.own.factor=2")[0] == 1
    assert heavylift("check", "rail.yaml", "--allow-code", "none.py")[0] == 2


def test_code_named_in_a_recording_is_not_run(heavylift: Command, tmp_path: Path) -> None:
    law(tmp_path)
    heavylift("run", "rail.yaml", "--in-process", "--allow-code", "mine.py")
    whole = (tmp_path / "rail.mcap").read_bytes()
    (tmp_path / "rail.mcap.part").write_bytes(whole[: whole.index(b"status")])
    (tmp_path / "mark").unlink()
    before = {*tmp_path.iterdir()}
    for line in ("replay --verify rail.mcap", "replay --live kernel rail.mcap", "resume rail.mcap.part"):
        code, text = heavylift(*line.split())
        assert (code, text.split(": '")[0]) == (1, f"heavylift: {line.split()[-1]}")
        assert text.endswith(f"then type: heavylift trust {tmp_path}\n")
    assert {*tmp_path.iterdir()} == before
    assert heavylift("replay", "--verify", "rail.mcap", "--allow-code", ".")[0] == 0


def test_python_code_runs_if_the_user_names_it_and_not_if_only_a_recording_names_it(
    heavylift: Command, tmp_path: Path
) -> None:
    (tmp_path / "ringed.py").write_text(
        "from subprocess import run\nfrom heavylift.nodes.zoo.token_ring import ring\n\n\n"
        "def build(n=3):\n    return ring(n, 1, 5)\n"
    )
    line = ("devs", "ringed.py:build(2)", "--until", "0.0001 ms", "--in-process", "-o", "ring.mcap")
    assert heavylift(*line)[0] == 0
    del sys.modules["ringed"]
    code, text = heavylift("replay", "--verify", "ring.mcap")
    assert (code, "ringed" in sys.modules) == (1, False)
    assert text == (
        "heavylift: ring.mcap: 'ringed.py' is code in a folder that you have not trusted; "
        f"read it, then type: heavylift trust {tmp_path}\n"
    )
    heavylift("trust", ".")
    assert heavylift("replay", "--verify", "ring.mcap")[0] == 0


def welcome(part: parts.Part) -> m.Fail:
    """What a node answers to a coordinator that gives it this part."""
    text: list[bytes] = []
    Participant(["east"], text.append, lambda _: None).handle(m.encode(m.Welcome(1, parts.encode(part))))
    answer = m.decode(text[0])
    assert isinstance(answer, m.Fail)
    return answer


def test_code_named_by_a_coordinator_is_not_run(heavylift: Command, tmp_path: Path) -> None:
    law(tmp_path)
    message = "node east: 'mine.py' is code in a folder that you have not trusted; read it, then type: heavylift trust"
    assert welcome(parts.ModelPart("mine.py:push")).sentence == f"{message} {tmp_path}"
    assert not (tmp_path / "mark").exists()


TOOLS = (
    "heavylift.kernel.errors:import_module('mine')",
    "heavylift.coordinator.participants.building:built('mine.py:push')",
    "heavylift.coordinator.run.models:run_models('mine.py:push')",
    "os:system('true')",
    "subprocess:run(['true'])",
    "builtins:exec('1')",
    "trusted.py:run(['true'])",
)


@pytest.mark.parametrize("reference", TOOLS)
def test_code_named_by_a_coordinator_cannot_reach_the_tools_that_a_trusted_file_imports(
    heavylift: Command, tmp_path: Path, reference: str
) -> None:
    """Neither Python, nor heavylift itself, nor what a trusted file imports is there to be called by data."""
    law(tmp_path)
    (tmp_path / "safe").mkdir()
    (tmp_path / "safe" / "trusted.py").write_text("from subprocess import run\n")
    heavylift("trust", "safe")
    answer = welcome(parts.ModelPart(reference.replace("trusted.py", str(tmp_path / "safe" / "trusted.py"))))
    assert answer.sentence.startswith("node east: ")
    assert not (tmp_path / "mark").exists()
