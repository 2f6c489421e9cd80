"""One table answers several questions: each quantity alone, at several limits, with the words that run the setting."""

import re
import shlex
from dataclasses import replace
from types import SimpleNamespace

import pytest
from heavylift.coordinator.cli import main
from heavylift.coordinator.tradeoff import METHODS, Rung, Setting, answers, chosen, ladder, page
from heavylift.coordinator.tradeoff.settings import settings
from heavylift.nodes.plan import Fidelity
from heavylift.nodes.scene import begun, load, parse
from measured_rows import row

ASK = ("rope tension", "swing", "lift-off time")
SLOW = row("1 ms", 10.0, rope_tension=5e-4, swing=2e-3)
FAST = row("5 ms", 1.0, rope_tension=0.03, swing=1e-4)
OWN = (
    "",
    "ask: [rope tension]\naccuracy: 3 %",
    "ask: [swing]\naccuracy: 1 %\nfidelity: {girder: elastic, motion: spatial}\nstep: 3 ms\nmethod: rk4",
    "fidelity: {rope mass: lumped, pads: standing, locked: [hinges]}\ntolerance: 3e-7",
)


def test_each_quantity_has_an_answer_at_each_limit():
    found = [(a.quantity, a.limit, a.row and a.row.how) for a in answers(("rope tension", "swing"), [SLOW, FAST])]
    decades = (0.1, 0.05, 0.01, 1e-3, 1e-4, 1e-5, 1e-6)
    tension = ("5 ms", "5 ms", "1 ms", "1 ms", None, None, None)
    swing = ("5 ms", "5 ms", "5 ms", "5 ms", "5 ms", None, None)
    assert found[:7] == [("rope tension", limit, how) for limit, how in zip(decades, tension, strict=True)]
    assert found[7:] == [("swing", limit, how) for limit, how in zip(decades, swing, strict=True)]


def test_what_no_setting_keeps_has_no_answer():
    found = answers(("swing",), [row("5 ms", 1.0, swing=0.04)])
    assert [a.row is None for a in found] == [False, False, True, True, True, True, True]


def test_the_page_tells_what_one_waits_for_each_answer():
    measured = SimpleNamespace(ask=["rope tension"], rows=[replace(SLOW, start_s=0.5), FAST], distributed=[])
    cells = re.findall("<td[^>]*>(.*?)</td>", page._answers(measured))
    assert cells[5::6][:4] == ["3 %", "3 %", "0.05 %", "0.05 %"]
    assert cells[3::6][:4] == ["1", "1", "10.5", "10.5"]
    assert cells[4::6][:5] == ["1", "1", "10", "10", ""]


def test_where_processes_were_measured_it_tells_what_they_add():
    apart = SimpleNamespace(wall_s=3.0, kernel_s=1.0)
    cells = re.findall(
        "<td[^>]*>(.*?)</td>",
        page._answers(SimpleNamespace(ask=["rope tension"], rows=[FAST], distributed=[None, apart])),
    )
    assert cells[:7] == ["rope tension", "10 %", str(FAST), "1", "1", "3", "3 %"]


@pytest.mark.parametrize("own", OWN)
@pytest.mark.large(beyond=1)
def test_what_is_typed_runs_what_was_measured(own, monkeypatch, tmp_path):
    """Whatever a scene asks or names itself: the same fidelity, method, tolerance and step for each rung."""
    path = tmp_path / "my lift.yaml"
    path.write_text(f"{begun('mine', 'lift')}\n{own}\n")
    scene = load(path, ["end=50 s"])
    rungs, finer = ladder(scene)
    assert finer is not None
    for setting in each_way([*rungs, finer, *chosen(scene, ASK, 0.01)]):
        assert typed(setting.words(scene), monkeypatch) == setting.plan(scene.plan)


def test_a_mechanism_is_run_as_its_file_says(monkeypatch):
    scene = load("arm", ["step=2 ms", "method=rk4"])
    for setting in each_way([Rung("as written", None)]):
        assert typed(setting.words(scene), monkeypatch) == setting.plan(scene.plan)


def test_a_command_names_its_scene_as_it_was_given_and_every_setting(tmp_path):
    massive = Rung(
        "", Fidelity(ropes="massive", lumps=2, rope_mass="lumped", pads="standing", locked=("crane.gantry",))
    )
    assert Setting(massive, "dop853", tolerance=1e-5).words(load("lift", ["end=50 s"])) == (
        "heavylift run lift --set 'end=50 s' --set 'fidelity={ropes: massive, lumps: 2, rope mass: lumped, "
        "slings: elastic, girder: rigid, motion: spatial, pads: standing, locked: [crane.gantry]}' "
        "--set tolerance=1e-05 --method dop853"
    )
    (tmp_path / "lift.yaml").write_text(begun("mine", "lift"))
    (tmp_path / "below").mkdir()
    here = f"{tmp_path}/below/../lift.yaml"
    said = Setting(Rung("", None), "rk4", step=0.005).words(load(here))
    assert said == f"heavylift run {here} --method rk4 --step '5 ms'"


def each_way(rungs):
    """Each rung with some methods, and each method with its loosest and its tightest setting."""
    ways = [(method, i) for method in METHODS for i in (0, -1)]
    for k, rung in enumerate(rungs):
        for method, i in ways[k :: len(rungs)]:
            yield settings(rung, method)[i]


def typed(words, monkeypatch):
    """The plan that a command line would run."""
    ran = []
    monkeypatch.setattr("heavylift.coordinator.run.run", lambda scene, *_, **__: ran.append(scene.plan))
    monkeypatch.setattr("heavylift.coordinator.run.progress.summary", lambda *_: None)
    monkeypatch.setattr("sys.argv", [*shlex.split(words), "--in-process"])
    main()
    return ran[0]


@pytest.mark.parametrize("own", OWN)
def test_what_a_scene_asks_or_names_itself_does_not_change_the_rungs(own):
    rungs = [chosen(parse(f"{begun('mine', 'lift')}\n{more}\n"), ASK, 0.01) for more in ("", own)]
    assert rungs[0] == rungs[1]


def test_a_rung_is_named_by_the_quantities_that_it_is_chosen_for():
    lift = load("lift")
    assert [rung.name for rung in chosen(lift, ("rope tension",), 0.01)] == ["chosen for rope tension"]
    names = " ".join(rung.name for rung in chosen(lift, ASK, 0.01))
    assert all(names.count(quantity) <= 1 for quantity in ASK)


def test_the_rungs_that_the_questions_would_be_given_are_measured():
    lift = load("lift")
    rungs = chosen(lift, ASK, 0.01)
    for ask in (*ASK, ", ".join(ASK)):
        given = load("lift", [f"ask=[{ask}]", "accuracy=1 %"]).plan.fidelity
        (name,) = (rung.name for rung in rungs if rung.fidelity == given)
        assert name == "chosen for all asked" or ask in name
