"""Every extreme case with every integrator gives a right result, a warning, or a refusal with its reason."""

import pytest
from cells import LEAN, cell
from table import EXTREMES

FOR_ALL = ("is nan", "is inf")  # refused before any integrator sees them; one of them is enough here
CELLS = [(x, i) for x in EXTREMES for i in (LEAN[:1] if x.name.endswith(FOR_ALL) else LEAN)]


@pytest.mark.parametrize(("extreme", "integrator"), CELLS, ids=[f"{x.name}-{i.name}" for x, i in CELLS])
def test_every_extreme_case_gives_a_right_result_or_a_warning_or_a_refusal(extreme, integrator):
    found = cell(extreme, integrator)
    print(found)
    assert found.right(integrator.bound), found
    assert "\n" not in found.refusal


def test_the_comparison_of_extreme_cases_detects_a_deliberately_wrong_answer():
    """The table would notice: the load of the first extreme, measured against a rope of another stiffness."""
    from cells import INTEGRATORS, Extreme
    from loads_and_swings import stiffness

    wrong = Extreme("wrong", lambda options: (stiffness(1.0).run(options)[0] + 0.01, stiffness(1.0).run(options)[1]))
    assert not cell(wrong, INTEGRATORS[0]).right(INTEGRATORS[0].bound)
