"""Method and tolerance follow from what a scene asks, by predicted cost; what the scene names itself stays as named."""

import pytest
from heavylift.kernel import SceneError
from heavylift.nodes.fidelity import METHODS
from heavylift.nodes.scene import check, load
from steps_down import RESOLUTION
from steps_taken import taken

FACTOR = 3.0  # between predicted and measured cost: durations of stages that wait for an event are known to that
NEARLY = 1.5  # times the cheapest


def steps(*settings, accuracy="1 %", ask="[swing]"):
    plan = load("lift", [f"ask={ask}", f"accuracy={accuracy}", *settings]).plan
    return plan.method, plan.tolerance, plan.step


def test_without_a_question_nothing_is_chosen():
    plan = load("lift", ["accuracy=1 %"]).plan
    assert (plan.method, plan.tolerance) == ("dopri5", 1e-4)
    assert load("lift", ["accuracy=1 %"]).verdict is None


def test_what_is_stiff_is_given_to_an_implicit_method():
    fine = "fidelity={ropes: massive, lumps: 12, girder: elastic, motion: across}"
    assert steps(fine, accuracy="5 %")[0] == "radau5"


def test_what_is_not_stiff_is_given_to_an_explicit_one():
    assert steps("fidelity={ropes: rigid, slings: rigid}", accuracy="5 %")[0] == "dopri5"


def test_what_a_method_cannot_do_it_is_not_given():
    named = "fidelity={ropes: rigid, slings: rigid}"
    verdict = load("lift", ["ask=[swing]", "accuracy=1 %", named]).verdict
    unfit = {s.method for s in verdict.steps if not s.allowed}
    assert "radau5" in unfit
    assert unfit.isdisjoint({"dopri5", "dop853"})


def test_the_tolerance_falls_with_the_accuracy():
    tolerances = [steps("method=radau5", accuracy=a)[1] for a in ("5 %", "1 %", "0.1 %", "0.01 %")]
    assert tolerances == sorted(tolerances, reverse=True)
    assert tolerances[0] > 100.0 * tolerances[-1]


def test_what_is_named_stays_as_named():
    assert steps("method=radau5")[0] == "radau5"
    assert steps("tolerance=1e-7")[1] == 1e-7
    assert steps("method=rk4", "step=10 ms") == ("rk4", 1e-4, 0.01)
    method, tolerance, _ = steps("method=radau5", "fidelity={ropes: rigid, slings: rigid}")
    assert (method, tolerance >= 3e-5) == ("radau5", True), "at its law's tolerance, fit or not"


def test_what_no_method_promises_is_said():
    text = str(check(load("lift", ["ask=[rope tension]", "accuracy=0.01 %", "tolerance=1e-3"])))
    assert " kept although unfit " in text
    assert " chosen    " not in text


@pytest.mark.parametrize("wrong", ["0", "-1", "tight", "2"])
def test_a_tolerance_that_is_none_is_told(wrong):
    with pytest.raises(SceneError, match="tolerance"):
        load("lift", [f"tolerance={wrong}"])


def test_the_report_tells_every_method_with_its_cost():
    loaded = load("lift", ["ask=[rope tension]", "accuracy=1 %"])
    lines = str(check(loaded)).splitlines()
    told = {name: next(line for line in lines if line.strip().startswith(name)) for name in METHODS}
    assert "chosen" in told[loaded.plan.method]
    assert "rope tension" in told["dopri5"]
    assert "evaluations" in told["dopri5"]
    assert "matrices" in told["radau5"]
    data = loaded.verdict.data()["steps"]
    assert data[0]["method"] == loaded.plan.method
    assert data[0]["cost"] == loaded.verdict.data()["cost"]["chosen"]


def test_the_chosen_method_is_the_cheapest_and_costs_what_was_predicted():
    runs = taken(3, 0.02)  # two hooks in a plane
    assert len(runs) >= 3
    assert runs[0].cost <= NEARLY * min(run.cost for run in runs)
    for run in runs:
        assert 1.0 / FACTOR < run.predicted.cost.product / run.cost < FACTOR, run
        for quantity in run.ask:
            assert run.errors[quantity] <= run.predicted.errors[quantity] + RESOLUTION[quantity], (run, quantity)
