"""What a scene asks is one or more of four quantities, each once; a wrong one is told in one sentence."""

import pytest
from heavylift.kernel.errors import SceneError
from heavylift.nodes.fidelity import ASKABLE
from heavylift.nodes.scene import load


def test_a_wrong_quantity_lists_all_that_can_be_asked():
    with pytest.raises(SceneError) as told:
        load("lift", ["ask=[tension]"])
    assert "'tension' is not known here" in str(told.value)
    assert f"can be asked: {', '.join(ASKABLE)}" in str(told.value)


def test_a_quantity_is_asked_once():
    with pytest.raises(SceneError, match="'swing' is asked twice: once is enough"):
        load("lift", ["ask=[swing, position, swing]"])
