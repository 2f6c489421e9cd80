"""The reported number of evaluations of the right-hand side, Jacobians included, equals the number of calls."""

import pytest
from scipy_peers import PEERS
from small_scenes import SECOND, hung, started


@pytest.mark.parametrize("method", ["dopri5", "dop853", "radau5", *sorted(PEERS)])
def test_the_reported_number_of_rate_evaluations_equals_the_number_of_calls(method):
    """On floats every evaluation is a call of the function that the native code calls."""
    simulation = started(hung(60.2), method=method, tolerance=1e-3, native=False)
    rate, made = simulation.method.f_rate, [0]
    evaluate = rate.body

    def evaluated(**given):
        made[0] += 1
        return evaluate(**given)

    rate.body = evaluated
    calls = simulation.native.code.call

    def located(name, *blocks):  # SciPy's searches for events are not counted
        before = made[0]
        calls(name, *blocks)
        if name not in ("advance", "step"):
            made[0] = before

    if method in PEERS:
        simulation.native.code.call = located
    else:
        simulation.native.set(top=float("inf"))  # so that no peak is looked for
    before = simulation.native.evaluations
    simulation.run(SECOND // 4)
    assert made[0] == simulation.native.evaluations - before > 20


def test_fixed_steps_cost_as_many_evaluations_as_their_tableau_has_stages():
    simulation = started(hung(60.2), method="rk4", step=0.01)
    simulation.run(SECOND // 2)
    assert simulation.native.evaluations == 4 * simulation["accepted"]
