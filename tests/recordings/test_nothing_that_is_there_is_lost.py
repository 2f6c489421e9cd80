"""Outputs and what stands where they are to be written: earlier ones stay or are replaced on demand, the rest stays."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable
from pathlib import Path

import pytest
from heavylift.kernel import OutputError, RecordingError
from heavylift.recordings import Recorder, Recording, curves, export, overlay, plot, recover, report, storyboard, view
from heavylift.recordings.write import PartFile

Begin = Callable[[], Recorder]
Obstacle = Callable[[Path], None]


def recorded_at(out: Path, force: bool = False) -> Path:
    """The smallest recording."""
    return Recorder(out, {"scene": "lift"}, force=force).close()


def is_link(out: Path) -> None:
    target = out.parent / "target" / out.name
    target.parent.mkdir()
    target.write_bytes(b"precious")
    out.symlink_to(target)


def is_dangling_link(out: Path) -> None:
    out.symlink_to(out.parent / "nowhere")


def is_folder(out: Path) -> None:
    out.mkdir()


def is_pipe(out: Path) -> None:
    os.mkfifo(out)


def is_socket(out: Path) -> None:
    with socket.socket(socket.AF_UNIX) as s:
        here = os.getcwd()
        os.chdir(out.parent)  # a socket's path is short
        s.bind(out.name)
        os.chdir(here)


def is_device(out: Path) -> None:
    if os.geteuid() != 0:
        pytest.skip("only root makes devices")
    os.mknod(out, 0o20666, os.makedev(1, 3))


def is_scene(out: Path) -> None:
    out.write_text("# my lift\nheavylift: 1\n" if out.suffix == ".mcap" else "name: lift\n")


def is_foreign(out: Path) -> None:
    out.write_bytes({".mcap": b"\x89MCAP0\r\n\x01" + bytes(40), ".png": b"\x89PNG\r\n"}.get(out.suffix, b"a;b\n1;2\n"))


def is_empty(out: Path) -> None:
    out.touch()


OBSTACLES = [
    is_link,
    is_dangling_link,
    is_folder,
    is_pipe,
    is_socket,
    is_device,
    is_scene,
    is_foreign,
    is_empty,
]
WRITERS: dict[str, Callable[[Path, Path, bool], Path]] = {
    "run.mcap": lambda rec, out, force: recorded_at(out, force),
    "tension.png": lambda rec, out, force: plot(rec, out, force=force),
    "lift.svg": lambda rec, out, force: storyboard(rec, out, force=force),
    "curves.html": lambda rec, out, force: curves(rec, ["rope/tension/*"], out, force),
    "curves.svg": lambda rec, out, force: curves(rec, ["rope/tension/*"], out, force),
    "both.png": lambda rec, out, force: overlay(rec, rec, out, ["rope/tension/*"], force),
    "page.html": lambda rec, out, force: view(rec, out, force=force),
    "report.html": lambda rec, out, force: report(rec, out, force=force),
    "table.csv": lambda rec, out, force: export(rec, out, force=force),
    "saved.mcap": lambda rec, out, force: recover(cut(rec), out, force).path,
}
QUICK = {"run.mcap", "page.html", "table.csv", "saved.mcap"}


def cut(rec: Path) -> Path:
    """What a kill leaves of a recording: its last chunk, and no result."""
    part, (*_, last) = rec.with_name("cut.mcap.part"), Recording(rec)._file.summary.chunk_indexes
    part.write_bytes(rec.read_bytes()[: last.chunk_start_offset + last.chunk_length + 3])
    return part


def all_below(folder: Path) -> dict[str, tuple[int, bytes]]:
    """Every name, with what stands there."""
    return {
        str(p.relative_to(folder)): (p.lstat().st_mode, p.read_bytes() if p.is_file() and not p.is_symlink() else b"")
        for p in sorted(folder.rglob("*"))
    }


@pytest.mark.parametrize("force", [False, True], ids=["", "forced"])
@pytest.mark.parametrize("name", ["run.mcap", "tension.png", "table.csv"])
@pytest.mark.parametrize("obstacle", OBSTACLES, ids=lambda f: f.__name__)
def test_an_existing_file_that_heavylift_did_not_write_is_never_overwritten(
    obstacle: Obstacle, name: str, force: bool, recorded: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out" / name
    out.parent.mkdir()
    obstacle(out)
    before = all_below(out.parent)
    with pytest.raises(OutputError, match=rf"^{out}: this is a ") as error:
        WRITERS[name](recorded, out, force)
    assert "\n" not in str(error.value)
    assert all_below(out.parent) == before


@pytest.mark.parametrize(
    "name", [x if QUICK & {x} else pytest.param(x, marks=pytest.mark.large(beyond=1)) for x in WRITERS]
)
def test_an_earlier_output_file_is_kept_and_the_new_file_gets_the_next_free_name(
    name: str, recorded: Path, tmp_path: Path
) -> None:
    write, out = WRITERS[name], tmp_path / "out" / name
    out.parent.mkdir()
    assert write(recorded, out, False) == out
    first = out.read_bytes()
    second, third = (out.with_name(f"{out.stem}-{n}{out.suffix}") for n in (2, 3))
    second.touch()
    assert write(recorded, out, False) == third
    assert (out.read_bytes(), second.read_bytes()) == (first, b"")
    out.write_bytes(first + b"tail")
    assert write(recorded, out, True) == out
    assert not out.read_bytes().endswith(b"tail")
    assert set(out.parent.iterdir()) == {out, second, third}


@pytest.mark.parametrize("name", ["run.txt", "run", "run.yaml", "run.mcap.part"])
def test_a_recording_name_without_the_ending_mcap_is_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(OutputError) as error:
        recorded_at(tmp_path / name)
    assert str(error.value) == f"{tmp_path / name}: the file name of a recording must end in .mcap; choose such a name"
    assert not any(tmp_path.iterdir())


@pytest.mark.parametrize("ending", [".part", ".commands"])
@pytest.mark.parametrize("force", [False, True], ids=["", "forced"])
def test_writing_an_output_does_not_follow_a_symbolic_link(ending: str, force: bool, tmp_path: Path) -> None:
    is_link(tmp_path / f"run.mcap{ending}")
    before = all_below(tmp_path)
    with pytest.raises(OutputError, match=rf"run.mcap{ending}: this is a link and will not be overwritten"):
        recorded_at(tmp_path / "run.mcap", force)
    assert all_below(tmp_path) == before


def test_the_option_force_of_a_new_run_does_not_delete_the_partial_recording_of_a_killed_run(
    begin: Begin, tmp_path: Path
) -> None:
    part, orders = tmp_path / "run.mcap.part", tmp_path / "run.mcap.commands"
    with begin() as rec:
        left = part.read_bytes()
    rec.path.unlink()
    part.write_bytes(left)
    orders.write_bytes(b"orders")
    assert recorded_at(tmp_path / "run.mcap").name == "run-2.mcap"
    assert (part.read_bytes(), orders.read_bytes()) == (left, b"orders")
    before = all_below(tmp_path)
    with pytest.raises(
        OutputError,
        match=rf"{part}: this file was left by a run that was cut off and will not be overwritten; .*resume {part}",
    ):
        recorded_at(tmp_path / "run.mcap", force=True)
    assert all_below(tmp_path) == before


@pytest.mark.parametrize("size", [0, 60, 80])
def test_the_option_force_replaces_a_partial_file_that_holds_no_run(size: int, begin: Begin, tmp_path: Path) -> None:
    part = tmp_path / "run.mcap.part"
    with begin() as rec:
        left = part.read_bytes()
    rec.path.unlink()
    part.write_bytes(left[:size])
    (tmp_path / "run.mcap.commands").write_bytes(b"orders")
    assert recorded_at(tmp_path / "run.mcap", force=True).name == "run.mcap"
    assert [p.name for p in tmp_path.iterdir()] == ["run.mcap"]


def test_concurrent_runs_with_the_same_recording_name_write_separate_files(begin: Begin, tmp_path: Path) -> None:
    recorders = [begin() for _ in range(4)]
    with pytest.raises(OutputError) as error:
        recorded_at(tmp_path / "run.mcap", force=True)
    assert str(error.value) == (
        f"{tmp_path}/run.mcap.part: another run is writing this file; wait for it or choose another name with -o"
    )
    names = [rec.close().name for rec in recorders]
    assert names == ["run.mcap", "run-2.mcap", "run-3.mcap", "run-4.mcap"]
    assert all(Recording(tmp_path / name).result["status"] == "finished" for name in names)


@pytest.mark.parametrize("come", [is_foreign, is_folder, is_dangling_link, recorded_at], ids=lambda f: f.__name__)
def test_a_file_that_gets_the_name_of_the_recording_during_a_run_is_kept(
    come: Obstacle, begin: Begin, tmp_path: Path
) -> None:
    rec = begin()
    come(tmp_path / "come.mcap")
    (tmp_path / "come.mcap").rename(tmp_path / "run.mcap")
    before = all_below(tmp_path)["run.mcap"]
    assert rec.close() == rec.path == tmp_path / "run-2.mcap"
    assert all_below(tmp_path)["run.mcap"] == before
    assert Recording(tmp_path / "run-2.mcap").result["status"] == "finished"


def test_output_files_get_their_names_on_a_file_system_without_unnamed_temporary_files(
    recorded: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delattr(os, "O_TMPFILE")
    assert recorded_at(recorded).name == "run-2.mcap"
    assert view(recorded, tmp_path / "x.html").name == "x.html"
    assert view(recorded, tmp_path / "x.html", force=True).name == "x.html"
    with pytest.raises(TypeError), PartFile(tmp_path / "y.html", "a page", (".html",)) as file:
        file.stream.write("no bytes")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run-2.mcap", "run.mcap", "x.html"]


def deleted(part: Path) -> None:
    part.unlink()


def renamed(part: Path) -> None:
    part.rename(part.with_name("away.mcap"))


def replaced(part: Path) -> None:
    part.with_name("other").write_bytes(part.read_bytes())
    part.with_name("other").replace(part)


def replaced_by_a_link(part: Path) -> None:
    renamed(part)
    part.symlink_to("away.mcap")


def cut_off(part: Path) -> None:
    os.truncate(part, part.stat().st_size // 2)


def emptied(part: Path) -> None:
    os.truncate(part, 0)


def longer(part: Path) -> None:
    with part.open("ab") as file:
        file.write(b"more")


def overwritten(part: Path) -> None:
    with part.open("r+b") as file:
        file.seek(50)
        file.write(b"other bytes")


NOTICED = {
    deleted: "deleted or renamed",
    renamed: "deleted or renamed",
    replaced: "replaced by another file",
    replaced_by_a_link: "replaced by another file",
    cut_off: "cut",
    emptied: "cut",
    longer: "changed by another program",
    overwritten: "changed by another program",
}


@pytest.mark.parametrize("at", ["the next flush", "the end"])
@pytest.mark.parametrize("harm", NOTICED, ids=lambda f: f.__name__)
def test_a_change_of_the_recording_file_by_another_program_during_a_run_is_detected(
    harm: Obstacle, at: str, begin: Begin, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if at == "the next flush":
        monkeypatch.setattr("heavylift.recordings.write.sink.FLUSH", 0.0)
    rec = begin()
    part = tmp_path / "run.mcap.part"
    harm(part)
    harmed = all_below(tmp_path)
    with pytest.raises(RecordingError) as error:
        rec.settle(1) if at == "the next flush" else rec.close()
    assert str(error.value) == (
        f"{part}: was {NOTICED[harm]} while it was written; leave the file alone until it is complete, and start again"
    )
    assert all_below(tmp_path).keys() == harmed.keys()


def test_reading_the_file_or_changing_its_rights_during_a_run_does_not_spoil_the_recording(
    begin: Begin, tmp_path: Path
) -> None:
    rec = begin()
    part = tmp_path / "run.mcap.part"
    part.read_bytes()
    os.utime(part, ns=(1, 1))
    part.chmod(0o600)
    rec.settle(1)
    os.link(part, tmp_path / "backup")
    assert rec.close() == tmp_path / "run.mcap"
    assert Recording(rec.path).result["status"] == "finished"
