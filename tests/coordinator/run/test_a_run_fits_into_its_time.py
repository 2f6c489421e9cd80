"""`--within` and `--real-time`: the best accuracy that fits, as settings that repeat the run; too little is refused."""

import re

import pytest
from heavylift.coordinator.run import budget, time_budget
from heavylift.kernel import SceneError
from heavylift.nodes.scene import load

ACCURACY = re.compile(r"to ([\d.]+) %, about ([\d.]+) s in all")


@pytest.fixture(autouse=True)
def machine(monkeypatch):
    """One with slow arithmetic whose clock stands while settings are chosen; nothing is kept from another test."""
    kept = {}
    monkeypatch.setattr(time_budget, "write_cached", kept.__setitem__)
    monkeypatch.setattr(time_budget, "read_cached", lambda name: kept.get(name, b""))
    monkeypatch.setattr(time_budget, "OPERATION_s", 1e-6)
    monkeypatch.setattr(time_budget, "elapsed", lambda: 1.0)
    monkeypatch.setattr(time_budget, "_probe", lambda: time_budget.PROBE_s)
    return monkeypatch


def told(within: str = "", **more) -> tuple[float, float]:
    """Accuracy [%] and seconds."""
    found = ACCURACY.search(budget("lift", [], within, **more).told)
    assert found
    return float(found[1]), float(found[2])


def test_more_time_is_more_accurate_and_the_time_is_kept():
    found = {seconds: told(f"{seconds} s") for seconds in (3.0, 5.0, 20.0)}
    assert all(about <= seconds for seconds, (_, about) in found.items())
    accuracies = [accuracy for accuracy, _ in found.values()]
    assert accuracies == sorted(accuracies, reverse=True)
    assert accuracies[0] > accuracies[-1]


def test_on_a_slow_machine_less_fits(machine):
    fast = told("4 s")[0]
    machine.setattr(time_budget, "_probe", lambda: 1.5 * time_budget.PROBE_s)
    assert told("4 s")[0] > fast


def test_what_is_not_promised_is_not_chosen_however_much_time_there_is():
    scene = budget("lift", [], "1000 h").scene
    assert scene.verdict.notes == ()


def test_the_settings_that_are_told_give_the_same_plan():
    fitted = budget("lift", ["gravity=9.8 m/s2"], "4 s")
    settings = re.findall(r"--set '(.*?)'", fitted.told)
    assert load("lift", ["gravity=9.8 m/s2", *settings]).plan == fitted.scene.plan
    assert fitted.scene.scene.ask == ("rope tension",)


def test_too_little_is_refused_with_what_is_enough():
    sentence = (
        r"^--within '1500 ms': too short, for rope tension to .* % this machine needs about ([\d.]+) s; give it more$"
    )
    with pytest.raises(SceneError, match=sentence) as no:
        budget("lift", [], "1500 ms")
    least = float(re.search(sentence, str(no.value))[1])
    assert told(f"{least} s")[1] <= least
    with pytest.raises(SceneError, match=f"about {least} s"):
        budget("lift", [], f"{0.9 * least} s")


def test_a_run_of_the_same_plan_tells_what_the_next_one_takes():
    found = told("4 s")[0]
    budget("lift", [], "4 s").took(60.0, 30.0)
    assert told("4 s")[0] > found


def test_a_run_that_compiles_says_nothing_of_the_next_one(machine):
    fitted = budget("lift", [], "4 s")
    machine.setattr(time_budget, "_code", lambda: frozenset(["new.o"]))
    fitted.took(60.0, 30.0)
    assert told("4 s")[1] < 4.0


def test_real_time_is_the_time_of_the_scene_over_a_factor():
    lasts = time_budget.lasts(load("lift"))
    assert told(factor=lasts / 4.0) == told("4 s")


@pytest.mark.parametrize(
    ("scene", "settings", "options", "sentence"),
    [
        ("lift", ["accuracy=1 %"], {"within": "9 s"}, "it chooses the accuracy; leave the setting 'accuracy' out"),
        ("lift", [], {"within": "9 s", "factor": 2.0}, "give one of --within, --real-time and --rate"),
        ("lift", [], {"factor": 2.0, "rate": 1.0}, "give one of --within, --real-time and --rate"),
        ("lift", [], {"factor": 0.0}, "give a number above 0"),
        ("lift", [], {"within": "soon"}, "--within 'soon': "),
        (
            "pendulum",
            [],
            {"within": "9 s"},
            "nothing is predicted here: what is made of parts is modelled as it is written",
        ),
    ],
)
def test_what_cannot_be_is_refused(scene, settings, options, sentence):
    with pytest.raises(SceneError) as no:
        budget(scene, settings, **options)
    assert sentence in str(no.value)


def test_seconds_count_from_the_start_of_the_process():
    assert 0.0 < time_budget.elapsed() < 1e6
