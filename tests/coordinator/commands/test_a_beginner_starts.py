"""What helps a beginner: a scene to start from, a schema for the editor, a look at the installation."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from heavylift.coordinator.commands import HealthFinding, app, findings
from heavylift.nodes.scene import bundled, json_schema, load
from ruamel.yaml import YAML
from typer.testing import CliRunner


def test_a_new_scene_is_a_copy_that_runs_under_its_own_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name, like in (("my-lift", "lift"), ("swing", "pendulum")):
        assert CliRunner().invoke(app, ["new", name, "--like", like]).exit_code == 0
        mine, theirs = load(f"{name}.yaml").plan, load(like).plan
        assert mine.name == name
        assert len(mine.actions) == len(theirs.actions)
        text = (tmp_path / f"{name}.yaml").read_text()
        assert f"# See it: heavylift plot {name}.mcap " in text
        renamed = text.replace(f"name: {name}", f"name: {like}", 1).replace(f"{name}.mcap", f"{like}.mcap")
        pairs = zip(renamed.splitlines(), bundled()[like].read_text().splitlines(), strict=True)
        different = [ours for ours, other in pairs if ours != other]
        assert all(x.startswith("# project: ") for x in different), "the head of the report is that of another lift"


def test_new_scenes_never_overwrite_existing_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.yaml").write_text("a day's work\n")
    message = CliRunner().invoke(app, ["new", "mine"])
    assert str(message.exception) == "mine.yaml: exists already and will not be overwritten; choose another name"
    assert (tmp_path / "mine.yaml").read_text() == "a day's work\n"


def test_the_json_schema_accepts_all_bundled_scenes_and_rejects_faulty_ones() -> None:
    jsonschema = pytest.importorskip("jsonschema", reason="no package 'jsonschema' (extra test)")
    schema = json_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    for path in bundled().values():
        scene = YAML(typ="safe").load(path.read_text())
        assert [error.message for error in validator.iter_errors(scene)] == [], path.name
    scene["cranes"] = {"west": {"type": "goliath-900", "at": "40 m", "hieght": "1 m"}}
    (wrong,) = validator.iter_errors(scene)
    assert list(wrong.absolute_path) == ["cranes", "west"]
    assert "hieght" in wrong.message


def test_the_json_schema_of_scenes_states_the_unit_and_default_and_meaning_of_each_key() -> None:
    schema = json_schema()
    types = schema["$defs"]["CraneKeys"]["allOf"]
    crane = next(x["then"] for x in types if x["if"]["properties"]["type"]["const"] == "goliath-900")["properties"]
    assert crane["hook capacity"]["default"] == "450 t"
    assert crane["gantry speed"]["default"] == "30 m/min"
    assert crane["rails"]["default"] == ["0 m", "400 m"]
    assert (crane["highest hook"]["default"], crane["highest hook"]["dimension"]) == ("80 m", "length")
    off_lead = schema["$defs"]["LiftLimits"]["properties"]["off-lead"]
    assert off_lead["description"].startswith("of ropes that carry a load; assumed")


def test_the_command_doctor_checks_the_installation_of_heavylift() -> None:
    found = {finding.what: finding for finding in findings()}
    assert {found[name].state for name in ("heavylift", "eclipse-zenoh", "ruamel.yaml", "cache")} == {"ok"}
    assert found["a short run"].message.startswith("21 samples of a pendulum in ")


def test_the_command_doctor_reports_a_broken_installation_with_exit_code_1(monkeypatch: pytest.MonkeyPatch) -> None:
    message = [
        HealthFinding("numpy", "ok", "2"),
        HealthFinding("browser", "missing", "none"),
        HealthFinding("cache", "broken", "read-only"),
    ]
    monkeypatch.setattr("heavylift.coordinator.commands.health.findings", lambda: iter(message))
    result = CliRunner().invoke(app, ["doctor", "--json"])
    assert [line["state"] for line in json.loads(result.output)] == ["ok", "missing", "broken"]
    assert result.exit_code == 1
    monkeypatch.setattr("heavylift.coordinator.commands.health.findings", lambda: iter(message[:2]))
    assert CliRunner().invoke(app, ["doctor"]).exit_code == 0
