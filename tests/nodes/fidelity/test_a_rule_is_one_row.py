"""The recipe for a fidelity rule: a function in `RULES`, taken if its predicted error fits, and told either way."""

from importlib import import_module

import pytest
from heavylift.nodes.fidelity import RULES, Choice
from heavylift.nodes.scene import bundled, check, parse

CHOOSE = import_module("heavylift.nodes.fidelity.choose")  # whose function has its name, too
ASKED = ["ask=[rope tension]", "accuracy=0.3 %"]  # at which a girder bends, by the rules that there are


def asked():
    """The bundled lift, of which no verdict is kept."""
    return parse(bundled()["lift"].read_text(), overrides=ASKED, passing=True)


def stiff_girder(error: float):
    def rule(case, at):
        why = "its sag is small beside the stretch of the ropes"
        return Choice("stiff girder", "girder", {"girder": "rigid"}, 2, {"rope tension": error}, why)

    return rule


@pytest.mark.parametrize(("error", "girder", "told"), [(1e-4, "rigid", "0.01 %"), (0.05, "elastic", "5 %")])
def test_a_rule_is_taken_where_its_error_fits(error, girder, told, monkeypatch):
    assert asked().plan.fidelity.girder == "elastic"
    monkeypatch.setattr(CHOOSE, "RULES", (*RULES, stiff_girder(error)))
    scene = asked()
    assert scene.plan.fidelity.girder == girder
    line = next(line for line in str(check(scene)).splitlines() if "stiff girder" in line)
    assert told in line
