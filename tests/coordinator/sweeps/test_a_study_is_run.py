"""`heavylift sweep`: rows as they come, whatever happens; a study that was stopped goes on, nothing runs twice."""

from __future__ import annotations

import os
import shlex
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from pathlib import Path

import pytest
from heavylift.coordinator.cli import main
from heavylift.coordinator.run import run
from heavylift.coordinator.sweeps import sweep, sweeping
from heavylift.coordinator.sweeps.page import page
from heavylift.coordinator.sweeps.study import Study
from heavylift.coordinator.sweeps.sweeping import verified
from heavylift.kernel.errors import HeavyliftError, OutputError, ProtocolError, Stopped
from heavylift.nodes.scene import load
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


def test_a_row_is_the_run_with_its_settings(tmp_path: Path) -> None:
    study = studied(tmp_path / "study")
    assert statuses(study) == ["done", "done", "done", "done", "refused", "refused"]
    assert "mass" in study.rows[4]["sentence"]
    again = run(load("pendulum", study.rows[3]["settings"]), tmp_path / "again.mcap", in_process=True)
    assert again.digest == study.rows[3]["digest"]
    frame = study.to_pandas()
    assert list(frame["input/end [s]"]) == [1.0, 2.0, 1.0, 2.0, 1.0, 2.0]
    assert parquet.read_table(tmp_path / "study" / "rows.parquet").num_rows == 6
    assert verified(study, 2) == [(0, True), (3, True)]
    assert "6 variants of pendulum: 4 done, 2 refused" in page(study)


def test_settings_and_what_a_scene_extends_are_part_of_it(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text("extends: pendulum\nname: mine\nend: 1 s\n")
    mine = load(tmp_path / "mine.yaml", ["samples=10 Hz"])
    study = sweep(mine, ["mechanism.bodies.load.mass={1 kg, -1 kg}"], into=tmp_path / "study", executor=AtOnce())
    assert statuses(study) == ["done", "refused"]
    again = run(load(mine.path, [*mine.settings, *study.rows[0]["settings"]]), tmp_path / "a.mcap", in_process=True)
    assert study.rows[0]["digest"] == again.digest
    assert "--set 'samples=10 Hz'" in study.rows[0]["command"]
    told = sweep(load("pendulum", ["end=1 s"]), ["gravity={x, 9.8 m/s2}"], into=tmp_path / "told", executor=AtOnce())
    assert "--set:1:9: error: gravity" in told.rows[0]["sentence"]


def test_every_engine_tells_the_same(tmp_path: Path) -> None:
    with ThreadPoolExecutor(2) as threads:
        found = studied(tmp_path / "threads", threads)
    assert digests(found) == digests(studied(tmp_path / "at once"))


def test_a_stopped_study_goes_on_and_runs_nothing_twice(tmp_path: Path) -> None:
    first, second = AtOnce(), AtOnce()

    def stop(study: Study, row: object) -> None:
        if row and len(rows) == 2:
            raise KeyboardInterrupt
        rows.append(row)

    rows: list[object] = []
    with pytest.raises(Stopped, match="the same command goes on"):
        studied(tmp_path / "study", first, watch=stop)
    kept = parquet.read_table(tmp_path / "study" / "rows.parquet").num_rows
    assert 1 <= kept < 6
    assert len(studied(tmp_path / "study", second).rows) == 6
    assert second.count == 6 - kept


def test_another_study_is_not_mixed_in(tmp_path: Path) -> None:
    studied(tmp_path / "study")
    with pytest.raises(OutputError, match="holds another study"):
        sweep("pendulum", VARY[:1], into=tmp_path / "study", executor=AtOnce())
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("dear reader")
    with pytest.raises(OutputError, match="holds no study"):
        studied(tmp_path / "mine")
    assert [x.name for x in (tmp_path / "mine").iterdir()] == ["letter.txt"]


def test_a_run_that_takes_too_long_is_cut_aloud(tmp_path: Path) -> None:
    study = studied(tmp_path / "study", limit=1e-9)
    assert statuses(study)[:4] == ["cut"] * 4
    assert "4 WERE CUT" in page(study)


def test_recordings_are_kept_where_they_are_asked_for(tmp_path: Path) -> None:
    study = sweep("pendulum", ["end={1 s}"], into=tmp_path / "study", executor=AtOnce(), keep="all")
    assert (tmp_path / "study" / study.rows[0]["recording"]).stat().st_size > 1000


def test_a_dead_worker_takes_one_variant_with_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[AtOnce] = []

    @contextmanager
    def pool(workers: int) -> Iterator[Executor]:
        made.append(AtOnce([len(made) < 2]))  # the first variant kills its worker, twice
        yield made[-1]

    monkeypatch.setattr(sweeping, "_pool", pool)
    found = sweep("pendulum", VARY, into=tmp_path / "study", workers=1)
    assert sorted(statuses(found)) == ["done", "done", "done", "lost", "refused", "refused"]
    monkeypatch.undo()
    assert "lost" not in statuses(studied(tmp_path / "study"))


def test_an_executor_of_others_that_dies_is_named(tmp_path: Path) -> None:
    with pytest.raises(ProtocolError, match="the executor has lost its workers"):
        studied(tmp_path / "study", AtOnce([False, True, True]))


def test_a_pool_of_processes_and_the_command_line(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    command = "heavylift sweep pendulum --vary 'end={1 s, 2 s}' --workers 1 --verify 2 -o study"
    monkeypatch.setattr("sys.argv", shlex.split(command))
    main()
    said = capsys.readouterr().out
    assert "2 variants of pendulum: 2 done" in said
    assert said.count("the same digest again") == 2
    assert (tmp_path / "study" / "summary.html").exists()
    row = parquet.read_table("study/rows.parquet").to_pylist()[1]
    assert row["process"] != os.getpid()
    assert row["command"] == "heavylift run pendulum --set 'end=2 s' -o pendulum-000001.mcap"


@pytest.mark.parametrize(
    "options", [{"keep": "some"}, {"workers": -1}, {"limit": 0.0}, {"sample": -1}, {"sample": 10, "design": "random"}]
)
def test_what_cannot_be_asked_is_one_sentence(tmp_path: Path, options) -> None:
    with pytest.raises(HeavyliftError):
        studied(tmp_path / "study", **options)
    assert not (tmp_path / "study").exists()
