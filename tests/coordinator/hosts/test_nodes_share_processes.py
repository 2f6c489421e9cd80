"""Which process hosts which nodes: dealt out, named by the user or by the scene; no byte of the digest moves."""

from __future__ import annotations

from pathlib import Path

import pytest
from heavylift.coordinator.commands import app
from heavylift.coordinator.run import run
from heavylift.coordinator.supervision import Processes
from heavylift.coordinator.transport import Placement, place, placement
from heavylift.kernel import SceneError
from heavylift.nodes.models import node_names
from heavylift.nodes.scene import bundled, load, parse
from heavylift.recordings import Recording
from lifting import unstated
from typer.testing import CliRunner

LIFT = ("commander", "crane", "loader-1", "loader-2", "loader-3", "block", "kernel")


def test_nodes_are_distributed_over_the_requested_processes_and_the_kernel_has_a_process_of_its_own() -> None:
    assert Placement.spread(LIFT, 4).processes == {
        "process-1": ("commander", "crane"),
        "process-2": ("loader-1", "loader-2"),
        "process-3": ("loader-3", "block"),
        "kernel": ("kernel",),
    }


@pytest.mark.parametrize("count", [7, 12])
def test_with_as_many_processes_as_nodes_each_node_has_a_process_of_its_own(count: int) -> None:
    assert Placement.spread(LIFT, count) == Placement.apart(LIFT)


def test_with_one_process_all_nodes_and_the_kernel_share_that_process() -> None:
    assert Placement.spread(LIFT, 1).processes == {"process-1": LIFT}


@pytest.mark.parametrize("count", range(1, 8))
def test_by_default_every_node_has_a_process_of_its_own(count: int) -> None:
    placement = Placement.spread(LIFT, count)
    assert len(placement.processes) == count
    assert sorted(placement.models) == sorted(LIFT)


def test_nodes_that_are_not_placed_have_their_own_process() -> None:
    found = place(LIFT, {"crane": "yard-a"}, ["block, loader-1=yard-a", "loader-2=yard-b"])
    assert found.processes == {
        "commander": ("commander",),
        "yard-a": ("crane", "loader-1", "block"),
        "yard-b": ("loader-2",),
        "loader-3": ("loader-3",),
        "kernel": ("kernel",),
    }


@pytest.mark.parametrize(("most", "told"), [(7, True), (8, False)])
def test_the_command_check_suggests_that_very_many_nodes_share_processes(
    monkeypatch: pytest.MonkeyPatch, most: int, told: bool
) -> None:
    """A yard of three lifts has two machines for each, a commander and the kernel, unless the scene places them."""
    monkeypatch.setattr(placement, "MANY", most)
    shown = CliRunner().invoke(app, ["check", "yard"]).output
    assert ("a run starts 8 processes: `--processes auto` takes as many as pay" in shown) is told
    assert not Placement.of(node_names(load("yard").plan), {"a-hall": "a", "a-block": "a"}).crowd


@pytest.mark.parametrize(
    ("given", "count", "told"),
    [
        (["crain=a"], 0, "--place 'crain=a': there is no node 'crain'; the nodes are commander, crane, "),
        (["crane"], 0, "--place 'crane': write nodes and their process, such as --place 'west,east=yard-a'"),
        (["crane,=a"], 0, "--place 'crane,=a': write nodes and their process"),
        (["crane=a", "crane=b"], 0, "--place 'crane=b': node 'crane' is placed twice; name it only once"),
        (["crane=a"], 2, "--processes and --place both assign nodes to processes; give one of them"),
        ([], -1, "--processes -1: a run needs at least one process"),
    ],
)
def test_a_wrong_placement_of_nodes_on_processes_is_refused(given: list[str], count: int, told: str) -> None:
    with pytest.raises(SceneError) as error:
        place(LIFT, {}, given, count)
    assert str(error.value).startswith(told)


@pytest.mark.parametrize("command", [["run", "lift"], ["devs", "heavylift.nodes.zoo.multi_server_queue:mmc"]])
@pytest.mark.parametrize("more", [["--processes", "2"], ["--place", "source=a"]])
def test_the_command_options_for_one_process_and_for_several_processes_exclude_each_other(
    command: list[str], more: list[str]
) -> None:
    message = CliRunner().invoke(app, [*command, "--in-process", *more])
    assert message.exit_code == 2
    assert "leave out --processes and --place" in message.output


def scene(placement: str) -> str:
    return f"{unstated(bundled()['lift'].read_text())}\nplacement:\n{placement}"


def test_a_scene_can_state_the_placement_of_its_nodes() -> None:
    loaded = parse(scene("  yard-a: [crane, block]\n  yard-b: {nodes: [loader-1]}\n"))
    assert node_names(loaded.plan) == LIFT
    assert loaded.facts.placement == {"crane": "yard-a", "block": "yard-a", "loader-1": "yard-b"}


@pytest.mark.parametrize(
    ("placement", "line", "told"),
    [
        ("  a: [crain]\n", 0, ":7: error: placement.a[0]: there is no node 'crain'"),
        ("  a: [crane]\n  b: [block, crane]\n", 1, ":14: error: placement.b[1]: node 'crane' is placed twice, in 'a'"),
        ("  a: {nodes: [crain]}\n", 0, ":15: error: placement.a.nodes[0]: there is no node 'crain'"),
        ("  a: []\n", 0, ":6: error: placement.a: 1 or more are needed here, not 0"),
        ("  a b: [crane]\n", 0, ":3: error: placement.a b: a name has letters, digits, '-' and '_' only"),
    ],
)
def test_an_invalid_placement_of_nodes_is_reported_with_its_line_in_the_scene(
    placement: str, line: int, told: str
) -> None:
    """`line`: of the placement, from 0."""
    text = scene(placement)
    line += text[: text.index(placement)].count("\n") + 1
    with pytest.raises(SceneError) as error:
        parse(text)
    assert str(error.value).startswith(f"scene.yaml:{line}{told}")


@pytest.fixture(scope="module")
def truth(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Digest of `lift` in the coordinator's process."""
    return run(load("lift"), tmp_path_factory.mktemp("truth") / "lift.mcap", in_process=True).digest


@pytest.mark.parametrize("count", [1, 2, 4, 12])
@pytest.mark.large(beyond=1)
def test_the_number_of_node_processes_does_not_change_any_byte_of_the_recording(
    truth: str, tmp_path: Path, count: int
) -> None:
    crew = Processes()
    placement = Placement.spread(LIFT, count)
    assert run(load("lift"), tmp_path / "lift.mcap", processes=crew, placement=placement).digest == truth
    assert set(crew.pids) == set(placement.processes)


@pytest.mark.large
def test_the_command_info_shows_which_nodes_shared_a_process(truth: str, tmp_path: Path) -> None:
    path = str(tmp_path / "lift.mcap")
    message = CliRunner().invoke(app, ["run", "lift", "--place", "crane,kernel=a", "--place", "block=b", "-o", path])
    assert message.exit_code == 0, message.output
    recording = Recording(path)
    assert recording.result["digest"] == truth
    assert recording.fact("placement")["a"] == ["crane", "kernel"]
    shown = CliRunner().invoke(app, ["info", path]).output
    assert "processes commander; a: crane, kernel; loader-1; loader-2; loader-3; b: block\n" in shown
