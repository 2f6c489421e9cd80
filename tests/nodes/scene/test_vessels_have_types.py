"""Bundled types of vessels: named by scenes, listed with cranes, merged under the keys of the scene."""

from __future__ import annotations

import json

import jsonschema
import pytest
from heavylift.coordinator.commands import app
from heavylift.kernel import SceneError
from heavylift.nodes.limits import checks_of
from heavylift.nodes.scene import json_schema, parse
from heavylift.nodes.scene.text import vessel_types
from ruamel.yaml import YAML
from typer.testing import CliRunner

SCENE = """
heavylift: 1
name: typed
end: 20 s
vessels:
  barge: {type: %s, mass: %s t, com: [0 m, 0 m, 1 m]%s}
actions: [{wait: 1 s}]
"""
WEIGHTS = {"barge-110": 14432, "barge-75": 4612.5}
MOORED = ", floating: {mooring: {surge: 100 kN/m}}"


@pytest.mark.parametrize("name", WEIGHTS)
def test_a_vessel_takes_size_and_hydrodynamics_from_its_type_and_its_other_keys_from_the_scene(name: str) -> None:
    text = SCENE % (name, WEIGHTS[name], MOORED)
    vessel = parse(text).scene.vessels["barge"]
    assert vessel.size[0] == float(name.removeprefix("barge-"))
    assert vessel.floating is not None
    assert (vessel.floating.hydrodynamics, vessel.floating.mooring.surge) == (name, 1e5)
    jsonschema.validate(YAML(typ="safe").load(text), json_schema())


def test_every_bundled_type_of_a_vessel_floats_level_with_the_mass_that_it_states() -> None:
    assert {*vessel_types()} == {*WEIGHTS}
    for name, of in vessel_types().items():
        mass = of["capacity"].split()[1]
        assert parse(SCENE % (name, mass, "")).plan.machines
        assert of["source"]


def test_in_a_scene_that_prescribes_the_motion_of_a_vessel_its_type_supplies_only_size_and_draught() -> None:
    given = ", motion: given, responses: {heave: [0.5 m/m, 0 deg]}"
    vessel = parse(SCENE % ("barge-75", 4000, given)).scene.vessels["barge"]
    assert (vessel.draught, vessel.floating) == (2.5, None)


def test_an_unknown_type_of_a_vessel_is_refused_with_the_closest_one() -> None:
    with pytest.raises(SceneError, match=r"(?s)'barge-11' is no type of a vessel.*barge-110"):
        parse(SCENE % ("barge-11", 14432, ""))


def test_types_of_vessels_are_listed_and_printed_with_those_of_cranes() -> None:
    runner = CliRunner()
    listed = json.loads(runner.invoke(app, ["types", "--json"]).stdout)
    assert {*WEIGHTS, "jib-60"} <= {*listed}
    assert "Capytaine" in listed["barge-75"]["source"]
    assert "vessel type: 1" in runner.invoke(app, ["types", "barge-75"]).stdout


def test_wave_interaction_of_two_vessels_is_reported_as_not_checked() -> None:
    both = SCENE.replace("\nactions", "\n  ship: {like: barge, at: [0 m, 60 m, 0 m]}\nactions")
    found = checks_of(parse(both % ("barge-110", 14432, MOORED)).plan, [], [], None, [])
    (row,) = [x for x in found if x.quantity == "interaction"]
    assert (row.state, row.sentence.split(":")[0]) == ("amber", "waves between barge and ship")
    alone = checks_of(parse(SCENE % ("barge-110", 14432, MOORED)).plan, [], [], None, [])
    assert not [x for x in alone if x.quantity == "interaction"]
