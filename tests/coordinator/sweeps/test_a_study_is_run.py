"""`heavylift sweep`: rows as they come, whatever happens; a study that was stopped goes on, nothing runs twice."""

from __future__ import annotations

import os
import shlex
import signal
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from random import Random

import pytest
from heavylift.coordinator.cli import main
from heavylift.coordinator.run import run
from heavylift.coordinator.sweeps import Study, study_sheet, sweep, sweeping, verified
from heavylift.kernel import HeavyliftError, OutputError, ProtocolError, Stopped
from heavylift.nodes.scene import load
from heavylift.recordings.sheets import page_of
from pyarrow import parquet

VARY = ["mechanism.bodies.load.mass={1 kg, 2 kg, -1 kg}", "end={1 s, 2 s}"]


class AtOnce(Executor):
    """Runs what it is given at once, in this thread; `dies` at these calls, as a pool whose worker was killed."""

    def __init__(self, dies: Sequence[bool] = ()) -> None:
        self.count, self._dies = 0, iter(dies)

    def submit(self, f, /, *args, **kwargs):
        future: Future = Future()
        if next(self._dies, False):
            future.set_exception(BrokenProcessPool("a process died"))
        else:
            self.count += 1
            future.set_result(f(*args, **kwargs))
        return future


def studied(folder: Path, executor: Executor | None = None, **options) -> Study:
    return sweep("pendulum", VARY, into=folder, executor=executor or AtOnce(), **options)


def statuses(study: Study) -> list[str]:
    return [study.rows[number]["status"] for number in sorted(study.rows)]


def digests(study: Study) -> dict[int, str | None]:
    return {number: study.rows[number].get("digest") for number in sorted(study.rows)}


def test_a_row_of_a_study_equals_the_result_of_a_run_with_its_settings(tmp_path: Path) -> None:
    study = studied(tmp_path / "study")
    assert statuses(study) == ["done", "done", "done", "done", "refused", "refused"]
    assert "mass" in study.rows[4]["sentence"]
    again = run(load("pendulum", study.rows[3]["settings"]), tmp_path / "again.mcap", in_process=True)
    assert again.digest == study.rows[3]["digest"]
    frame = study.to_pandas()
    assert list(frame["input/end [s]"]) == [1.0, 2.0, 1.0, 2.0, 1.0, 2.0]
    assert parquet.read_table(tmp_path / "study" / "rows.parquet").num_rows == 6
    assert verified(study, 2) == [(0, True), (3, True)]
    assert "6 variants of pendulum: 4 done, 2 refused" in page_of(study_sheet(study))


def test_variants_of_a_study_include_the_settings_and_base_scenes_of_its_scene(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text("extends: pendulum\nname: mine\nend: 1 s\n")
    mine = load(tmp_path / "mine.yaml", ["samples=10 Hz"])
    study = sweep(mine, ["mechanism.bodies.load.mass={1 kg, -1 kg}"], into=tmp_path / "study", executor=AtOnce())
    assert statuses(study) == ["done", "refused"]
    again = run(load(mine.path, [*mine.settings, *study.rows[0]["settings"]]), tmp_path / "a.mcap", in_process=True)
    assert study.rows[0]["digest"] == again.digest
    assert "--set 'samples=10 Hz'" in study.rows[0]["command"]
    message = sweep(load("pendulum", ["end=1 s"]), ["gravity={x, 9.8 m/s2}"], into=tmp_path / "told", executor=AtOnce())
    assert "--set:1:9: error: gravity" in message.rows[0]["sentence"]


def test_a_study_has_the_same_rows_with_every_executor(tmp_path: Path) -> None:
    with ThreadPoolExecutor(2) as threads:
        found = studied(tmp_path / "threads", threads)
    assert digests(found) == digests(studied(tmp_path / "at once"))


def test_an_object_with_a_submit_method_is_accepted_as_executor(tmp_path: Path) -> None:
    """As those of submitit, whose jobs are no futures of Python's."""

    class Job:
        def __init__(self, call, words) -> None:
            self.exception, self.result = lambda: None, lambda: call(*words)
            self._asked = 0

        def done(self) -> bool:
            self._asked += 1
            return self._asked > 1

    class Cluster:
        def submit(self, call, *words):
            return Job(call, words)

    assert digests(studied(tmp_path / "cluster", Cluster())) == digests(studied(tmp_path / "at once"))


def test_a_stopped_study_continues_without_repeating_runs(tmp_path: Path) -> None:
    first, second = AtOnce(), AtOnce()

    def stop(study: Study, row: object) -> None:
        if row and len(rows) == 2:
            raise KeyboardInterrupt
        rows.append(row)

    rows: list[object] = []
    with pytest.raises(Stopped, match="the same command continues"):
        studied(tmp_path / "study", first, watch=stop)
    kept = parquet.read_table(tmp_path / "study" / "rows.parquet").num_rows
    assert 1 <= kept < 6
    assert len(studied(tmp_path / "study", second).rows) == 6
    assert second.count == 6 - kept


def test_a_folder_that_holds_another_study_is_refused(tmp_path: Path) -> None:
    studied(tmp_path / "study")
    with pytest.raises(OutputError, match="holds another study"):
        sweep("pendulum", VARY[:1], into=tmp_path / "study", executor=AtOnce())
    with pytest.raises(OutputError, match=r"holds another study \(limit 60 s, keep none\)"):
        studied(tmp_path / "study", limit=1.0, keep="all")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("dear reader")
    with pytest.raises(OutputError, match="is not a study"):
        studied(tmp_path / "mine")
    assert [x.name for x in (tmp_path / "mine").iterdir()] == ["letter.txt"]
    (tmp_path / "study" / "study.json").write_text("[]")
    with pytest.raises(OutputError, match="is not the definition of a study"):
        studied(tmp_path / "study")


def test_a_run_that_exceeds_its_wall_time_limit_is_ended_and_reported(tmp_path: Path) -> None:
    study = studied(tmp_path / "study", limit=1e-6)
    assert statuses(study)[:4] == ["cut"] * 4
    assert "4 WERE CUT" in page_of(study_sheet(study))


def test_a_study_counts_lifts_that_the_end_of_the_scene_cuts_off_as_unfinished(tmp_path: Path) -> None:
    study = sweep("lift", ["end={1 s}"], into=tmp_path / "study", executor=AtOnce())
    assert "1 red; 1 ARE UNFINISHED, for the scene ended before" in page_of(study_sheet(study))


def test_recordings_of_a_study_are_written_if_requested(tmp_path: Path) -> None:
    study = sweep("pendulum", ["end={1 s}"], into=tmp_path / "study", executor=AtOnce(), keep="all")
    assert (tmp_path / "study" / study.rows[0]["recording"]).stat().st_size > 1000


def test_a_worker_process_that_dies_loses_only_the_study_variant_that_it_was_running(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[AtOnce] = []

    def pool(workers: int) -> AtOnce:
        made.append(AtOnce([len(made) < 2]))  # the first variant kills its worker, twice
        return made[-1]

    monkeypatch.setattr(sweeping, "Pool", pool)
    found = sweep("pendulum", VARY, into=tmp_path / "study", workers=1)
    assert sorted(statuses(found)) == ["done", "done", "done", "lost", "refused", "refused"]
    monkeypatch.undo()
    assert "lost" not in statuses(studied(tmp_path / "study"))


def test_an_external_executor_that_dies_is_reported_by_name(tmp_path: Path) -> None:
    with pytest.raises(ProtocolError, match="the executor has lost its workers"):
        studied(tmp_path / "study", AtOnce([False, True, True]))


def test_a_sweep_started_on_the_command_line_runs_its_variants_in_a_process_pool(
    tmp_path: Path, monkeypatch, capsys
) -> None:
    monkeypatch.chdir(tmp_path)
    command = "heavylift sweep pendulum --vary 'end={1 s, 2 s}' --workers 1 --verify 2 -o study"
    monkeypatch.setattr("sys.argv", shlex.split(command))
    main()
    text = capsys.readouterr().out
    assert "2 variants of pendulum: 2 done" in text
    assert text.count("the same digest again") == 2
    assert (tmp_path / "study" / "summary.html").exists()
    row = parquet.read_table("study/rows.parquet").to_pylist()[1]
    assert row["process"] != os.getpid()
    assert row["command"] == "heavylift run pendulum --set 'end=2 s' -o pendulum-000001.mcap"


@pytest.mark.parametrize(
    ("option", "value", "told"),
    [
        ("keep", "some", "--keep 'some' is not a known choice; choose none, failed, all"),
        ("workers", -1, "--workers: -1 is not a non-negative integer"),
        ("workers", 2.5, "--workers: 2.5 is not a non-negative integer"),
        ("limit", 0.0, "--limit: 0.0 s is out of range"),
        ("limit", "x", "--limit: 'x' is not a number; give a number of seconds"),
        ("sample", True, "--sample: True is not a non-negative integer"),
        ("seed", "x", "--seed: 'x' is not a non-negative integer"),
        ("vary", [3], "--vary [3]: give texts PATH=VALUES"),
        ("executor", 3, "executor=3: give an object with `submit`"),
        ("into", 3, "3 is not a file name"),
    ],
)
def test_invalid_study_options_are_reported_in_one_sentence(tmp_path: Path, option: str, value, told: str) -> None:
    with pytest.raises(HeavyliftError) as found:
        sweep("pendulum", **{"vary": VARY, "into": tmp_path / "study", option: value})
    assert str(found.value).startswith(told)
    assert not (tmp_path / "study").exists()


@pytest.mark.parametrize(
    ("missing", "options", "told"),
    [
        ("pyarrow", {}, "a study needs pyarrow; install heavylift[sweep]"),
        ("SALib", {"vary": ["end=1..2 s"], "sample": 8}, "--sample needs SALib; install heavylift[sweep]"),
    ],
)
def test_a_missing_optional_package_for_studies_is_reported_in_one_sentence(
    tmp_path: Path, monkeypatch, missing: str, options, told
) -> None:
    monkeypatch.setitem(sys.modules, missing, None)
    with pytest.raises(HeavyliftError) as found:
        sweep("pendulum", **{"vary": VARY, "into": tmp_path / "study"} | options)
    assert str(found.value) == told
    assert not (tmp_path / "study").exists()


def test_a_study_with_an_unknown_sampling_design_is_refused(tmp_path: Path) -> None:
    with pytest.raises(HeavyliftError, match="--design 'random' is not a known design; choose sobol or lhs"):
        studied(tmp_path / "study", sample=10, design="random")


def test_a_study_whose_process_was_killed_can_be_continued(tmp_path: Path) -> None:
    """A child runs the study until it has written some rows and is killed without a word."""
    script = f"""
import os, sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from heavylift.coordinator.sweeps import study, sweeping
from test_a_study_is_run import studied
sweeping.WRITE_s = 0.0
append = study.Study.append
def once(self, rows):
    append(self, rows)
    if self.rows:
        os.kill(os.getpid(), 9)
study.Study.append = once
studied({str(tmp_path / "study")!r})
"""
    killed = subprocess.run([sys.executable, "-c", script], timeout=60, check=False)
    assert killed.returncode == -signal.SIGKILL
    rest = AtOnce()
    assert statuses(studied(tmp_path / "study", rest)) == ["done", "done", "done", "done", "refused", "refused"]
    assert rest.count < 6


@pytest.mark.parametrize("seed", range(2))
def test_a_study_variant_has_the_same_digest_in_a_worker_that_has_run_other_variants(tmp_path: Path, seed: int) -> None:
    """Random variants of several structures in one process, in two orders, and as `run` has them."""
    random = Random(seed)
    masses = ", ".join(f"{random.uniform(0.5, 5.0)!r} kg" for _ in range(2))
    vary = [f"mechanism.bodies.load.mass={{{masses}, 1 kg}}", "gravity={9.81 m/s2, 1 m/s2}", "end={0.3 s}"]

    class Backwards(AtOnce):
        def submit(self, f, task, variant):
            f(task, plan.variants[-1 - variant.number])
            return super().submit(f, task, variant)

    plan = sweeping.planned("pendulum", vary)
    forth = sweep("pendulum", vary, into=tmp_path / "forth", executor=AtOnce())
    back = sweep("pendulum", vary, into=tmp_path / "back", executor=Backwards())
    assert digests(forth) == digests(back)
    assert len(set(digests(forth).values())) == 6
    chosen = random.randrange(6)
    again = run(load("pendulum", forth.rows[chosen]["settings"]), tmp_path / "again.mcap", in_process=True)
    assert again.digest == forth.rows[chosen]["digest"]
