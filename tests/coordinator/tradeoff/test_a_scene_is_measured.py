"""`heavylift tradeoff` on a pendulum: what it finds, writes, and refuses in one sentence."""

import csv
import json
from dataclasses import replace

import pytest
from heavylift.coordinator.cli import main
from heavylift.coordinator.tradeoff import answers, long_enough, measure, percent, play, write
from heavylift.kernel import ModelError, SceneError
from heavylift.nodes.scene import load

SCENE = ["end=20 s"]


@pytest.fixture(scope="module")
def measured():
    return measure(load("pendulum", SCENE), "position", limit=1e-3, budget=60.0)


def errors(measured, method):
    return {r.how: r.errors["position"] for r in measured.rows if r.method == method}


def test_a_first_order_method_halves_its_error_with_its_step(measured):
    euler = errors(measured, "semi-implicit-euler")
    assert euler["10 ms"] / euler["5 ms"] == pytest.approx(2.0, rel=0.02)


def test_every_method_of_higher_order_passes_and_the_long_steps_of_euler_fail(measured):
    assert errors(measured, "semi-implicit-euler")["50 ms"] > 1e-3
    for method in ("rk4", "dopri5", "dop853"):
        assert all(e < 1e-6 for e in errors(measured, method).values())
    assert all(e < float(tolerance) for tolerance, e in errors(measured, "radau5").items()), "as long as they may be"
    assert measured.verdict.pick.passes(1e-3)
    assert measured.verdict.sentence.startswith("Use the setting as written, ")


def test_the_reference_has_converged(measured):
    assert measured.converged["tolerance 1e-09"]["position"] < 1e-9


def test_what_was_not_asked_is_told_with_its_reason(measured):
    assert measured.not_asked["lift-off time"] == "no stage of the scene ends 'until lifted'"


def test_page_table_and_figure_tell_the_same(measured, tmp_path):
    page, table, data, figure = (tmp_path / f"out{kind}" for kind in (".html", ".csv", ".json", ".png"))
    for path in (page, table, data, figure):
        write(measured, path)
    html = page.read_text()
    assert measured.verdict.sentence in html
    for answer in answers(measured.ask, measured.rows):
        row = answer.row
        seconds = f"<td>{row.waits_s:.3g}</td><td>{row.cpu_s:.3g}</td>"
        assert f"{seconds}<td>{percent(row.worst)}</td>" in html, "seconds, not a speed"
    assert "Position: largest difference at equal times since each stage began, relative to" in html
    assert "<script" not in html
    assert "http" not in html.replace("http-equiv", "").replace("http://www.w3.org", "")
    rows = list(csv.DictReader(table.open()))
    told = json.loads(data.read_text())
    assert len(rows) == len(told["settings"]) == len(measured.rows)
    assert [row["step or tolerance"] for row in rows] == [row.how for row in measured.rows]
    assert told["verdict"] == measured.verdict.sentence
    assert figure.read_bytes().startswith(b"\x89PNG")


def test_what_the_kernel_says_of_a_setting_stands_on_the_page(measured, tmp_path):
    """A step of a second bends a swing of ten out of shape."""
    plan = load("pendulum", ["end=20 s", "method=semi-implicit-euler", "step=1 s"]).plan
    notes = play(plan, 60.0).notes
    assert "is out of step by a tenth of a swing" in notes[0]
    first, *others = measured.rows
    html = write(replace(measured, rows=[replace(first, notes=notes), *others]), tmp_path / "out.html").read_text()
    assert "What the kernel said" in html
    assert "is out of step by a tenth of a swing" in html
    assert "What the kernel said" not in write(measured, tmp_path / "out.html").read_text()


def test_the_page_says_nothing_of_settings_that_there_are_not(measured, tmp_path):
    often = [replace(row, runs=3) for row in measured.rows]
    every = replace(measured, rows=often, settled=0)
    some = replace(measured, rows=[replace(often[0], runs=1), *often[1:]], settled=2)
    pages = [write(m, tmp_path / "out.html").read_text() for m in (every, some)]
    assert ["The others were run once" in page for page in pages] == [False, True]
    assert ["tighter ones were not run" in page for page in pages] == [False, True]


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--ask", "tension"], "--ask 'tension': a scene cannot be asked this; ask rope tension, swing, position,"),
        (["--ask", "rope tension"], "--ask 'rope tension': no rope of the scene carries anything; ask swing, position"),
        (["--budget", "1 ms"], "--budget 0.001 s: too small, the reference "),
        (["--budget", "soon"], "--budget 'soon': "),
        (["--accuracy", "20 %"], "--accuracy '20 %': 20 % is out of range"),
        (["--coupling"], "--coupling: nothing hangs on a hook rope in pendulum.yaml; leave the option out"),
        (["-o", "report.pdf"], "report.pdf: a trade-off is written as .html, .png, .svg, .csv or .json"),
    ],
)
def test_what_cannot_be_done_is_refused_in_one_sentence(monkeypatch, capsys, arguments, sentence):
    monkeypatch.setattr("sys.argv", ["heavylift", "tradeoff", "pendulum", "--set", "end=20 s", *arguments])
    with pytest.raises(SystemExit) as left:
        main()
    assert left.value.code == (2 if "report.pdf" in sentence else 1)
    said = [line for line in capsys.readouterr().err.splitlines() if line.startswith("heavylift: ")]
    assert len(said) == 1
    assert said[0].startswith(f"heavylift: {sentence}")


def test_a_scene_in_which_nothing_moves_has_no_trade():
    with pytest.raises(SceneError, match="nothing in it moves that a setting could be judged by"):
        measure(load("pendulum", [*SCENE, "mechanism.joints.pivot.start=0 deg"]), budget=30.0)


def test_a_run_that_takes_too_long_is_cut_and_says_where():
    plan = load("pendulum").plan
    with pytest.raises(ModelError, match=r"cut after 0 s of wall time, at \d+\.\d{3} s of the run"):
        play(plan, limit=0.0)


def test_a_scene_that_cuts_its_list_is_measured_to_the_end_of_it_for_its_swing_to_be_seen():
    lift, told = load("lift"), []
    longer = long_enough(lift, ("swing",), told.append)
    assert told == ["the scene ends after 60 s and cuts its action list: measured to the end of the list"]
    assert (longer.plan.end, longer.settings) == (None, ("end=null",))
    assert load("lift", longer.settings).plan.end is None, "what is typed ends there, too"
    assert long_enough(lift, ("position",), told.append) is lift
