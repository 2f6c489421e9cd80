"""One table answers several questions: each quantity alone, at several limits, with the words that run the setting."""

from types import SimpleNamespace

from heavylift.coordinator.tradeoff.answers import answers
from heavylift.coordinator.tradeoff.settings import Rung, Setting, chosen, ladder
from heavylift.nodes.scene import load
from heavylift.nodes.scene.plan import Fidelity
from measured_rows import row

ASK = ("rope tension", "swing", "lift-off time")
SLOW = row("1 ms", 10.0, rope_tension=5e-4, swing=2e-3)
FAST = row("5 ms", 1.0, rope_tension=0.03, swing=1e-4)


def test_each_quantity_has_an_answer_at_each_limit():
    asked = SimpleNamespace(ask=("rope tension", "swing"), rows=[SLOW, FAST])
    found = [(a.quantity, a.limit, a.row and a.row.how) for a in answers(asked)]
    assert found == [
        ("rope tension", 0.05, "5 ms"), ("rope tension", 0.01, "1 ms"), ("rope tension", 0.001, "1 ms"),
        ("swing", 0.05, "5 ms"), ("swing", 0.01, "5 ms"), ("swing", 0.001, "5 ms"),
    ]  # fmt: skip


def test_what_no_setting_keeps_has_no_answer():
    asked = SimpleNamespace(ask=("swing",), rows=[row("5 ms", 1.0, swing=0.04)])
    assert [a.row is None for a in answers(asked)] == [False, True, True]


def test_a_setting_can_be_typed():
    massive = Rung("+ rope mass", Fidelity(ropes="massive", lumps=2, girder="elastic", locked=("crane.gantry",)))
    assert Setting(massive, "dop853", tolerance=1e-5).words("lift") == (
        "heavylift run lift --set 'fidelity={ropes: massive, slings: elastic, girder: elastic, motion: spatial, "
        "lumps: 2, locked: [crane.gantry]}' --method dop853 --set tolerance=1e-05"
    )
    assert Setting(Rung("as written", None), "rk4", step=0.005).words("arm") == (
        "heavylift run arm --method rk4 --step '5 ms'"
    )


def test_what_is_typed_gives_the_rung_that_was_measured():
    lift = load("lift")
    rungs, finer = ladder(lift)
    assert finer is not None
    for rung in [*chosen(lift, ASK, 0.01), *rungs, finer]:
        assert modelled(load("lift", [rung.words]).plan.fidelity) == modelled(rung.fidelity)


def modelled(fidelity: Fidelity):
    """Without what says nothing: lumps of ropes that have none, the order of locked joints."""
    lumps = fidelity.lumps if fidelity.ropes == "massive" else 0
    return lumps, {*fidelity.locked}, fidelity.ropes, fidelity.slings, fidelity.girder, fidelity.motion


def test_the_rungs_that_the_questions_would_be_given_are_measured():
    lift = load("lift")
    rungs = chosen(lift, ASK, 0.01)
    for ask in (*ASK, ", ".join(ASK)):
        given = load("lift", [f"ask=[{ask}]", "accuracy=1 %"]).plan.fidelity
        (name,) = (rung.name for rung in rungs if rung.fidelity == given)
        assert name == "chosen for all asked" or ask in name
