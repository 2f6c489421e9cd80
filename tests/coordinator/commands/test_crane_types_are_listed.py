"""`heavylift types` lists crane types with what they lift and where their numbers are from, and prints their files."""

from __future__ import annotations

import json

import pytest
from heavylift.coordinator.commands import app
from heavylift.kernel import SceneError
from heavylift.nodes.scene.text import library, vessel_types
from typer.testing import CliRunner


def told(*words: str) -> str:
    result = CliRunner().invoke(app, ["types", *words], catch_exceptions=False)
    assert result.exit_code == 0
    return result.stdout


def test_every_crane_type_reports_its_capacity_and_source() -> None:
    text, found = told(), json.loads(told("--json"))
    assert [*found] == [*library(), *vessel_types()]
    for name, answer in found.items():
        assert (
            f"{name}: {answer['about']}\n    capacity: {answer['capacity']}\n    source: {answer['source']}\n" in text
        )
    assert [name for name in library() if "made up" not in found[name]["source"]] == []
    assert found["rough-terrain-59"]["source"].startswith(
        "chart, boom angles, foot of the boom and hook block by Terex"
    )


def test_the_types_command_prints_the_file_of_a_crane_type() -> None:
    assert told("jib-60") == library()["jib-60"].read_text()


def test_an_unknown_crane_type_is_reported() -> None:
    with pytest.raises(SceneError, match="there is no machine type 'jib-6': did you mean 'jib-60'"):
        told("jib-6")
