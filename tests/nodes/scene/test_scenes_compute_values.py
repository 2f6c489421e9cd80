"""Values of a scene that begin with `=` are arithmetic over its parameters, with units, in files and settings."""

import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.scene import bundled, load, parse

LIFT = """heavylift: 1
name: half
extends: lift
parameters: {half: 150 t, span: 40 m, arm: =span/2, who: goliath-900, lug: [1 m, 2 m, 3 m]}
block: {mass: =2*half}
cranes: {crane: {type: =who, at: =arm*2}}
"""


def test_expressions_in_a_scene_give_the_result_of_the_same_numbers():
    computed, plain = (parse(text).scene for text in (LIFT, "heavylift: 1\nname: half\nextends: lift\n"))
    assert computed.block == plain.block
    assert (
        parse(LIFT).plan.machines == parse(LIFT.replace("=who", "goliath-900").replace("=arm*2", "40 m")).plan.machines
    )


def test_settings_change_the_parameters_of_expressions_in_a_scene():
    assert parse(LIFT, "a.yaml", ["parameters.half=100 t"]).scene.block.mass == 200e3
    assert parse(LIFT, "a.yaml", ["block.mass==half + 1 t"]).scene.block.mass == 151e3


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ("=2*haf", "block.mass: there is no parameter 'haf'"),
        ("=half + span", "block.mass: kg and m cannot be added or subtracted"),
        ("=span", "block.mass: '40.0 m' is not a valid mass"),
        ("=half*(1 + 2", "block.mass: a closing bracket ) is missing here"),
    ],
)
def test_mistakes_in_arithmetic_expressions_of_a_scene_are_reported_with_file_and_line_and_key(
    wrong: str, sentence: str
):
    with pytest.raises(SceneError) as error:
        parse(LIFT.replace("=2*half", wrong), "half.yaml")
    assert str(error.value).startswith("half.yaml:5:")
    assert sentence in str(error.value)


def test_a_parameter_that_depends_on_itself_is_refused():
    with pytest.raises(SceneError, match="the parameter 'half' depends on itself"):
        parse(LIFT.replace("half: 150 t", "half: =half/2"))


@pytest.mark.parametrize("name", sorted(bundled()))
@pytest.mark.large(beyond=8)
def test_gravity_given_by_an_expression_gives_the_plan_of_its_value_in_any_bundled_scene(name: str):
    plain = load(name, ["gravity=8 m/s2"]).plan
    assert load(name, ["parameters.g=4 m/s2", "gravity==2*g"]).plan == plain
