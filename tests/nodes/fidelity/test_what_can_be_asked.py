"""What a scene asks is one or more of four quantities, each once; a wrong one is told in one sentence."""

import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.fidelity import ASKABLE
from heavylift.nodes.scene import load


def test_a_wrong_quantity_lists_all_that_can_be_asked():
    with pytest.raises(SceneError) as told:
        load("lift", ["ask=[tension]"])
    assert "'tension' is not known here" in str(told.value)
    assert f"can be asked: {', '.join(ASKABLE)}" in str(told.value)


def test_who_asks_without_an_accuracy_means_one_percent():
    one = load("lift", ["ask=[swing]"])
    assert one.verdict.question.accuracy == 0.01
    assert one.verdict.notes == ()
    assert one.plan == load("lift", ["ask=[swing]", "accuracy=1 %"]).plan


def test_who_asks_nothing_gets_rope_tensions_to_a_hundredth_of_a_percent():
    assert load("lift").plan.tolerance == load("lift", ["accuracy=0.01 %"]).plan.tolerance


def test_a_quantity_is_asked_once():
    with pytest.raises(SceneError, match="'swing' is asked twice: once is enough"):
        load("lift", ["ask=[swing, position, swing]"])
