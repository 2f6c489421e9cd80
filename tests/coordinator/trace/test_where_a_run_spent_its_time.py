"""`heavylift trace`: who worked, who waited for whom, in tables, as data, and in a file for trace viewers."""

from __future__ import annotations

import json
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest
from heavylift import run_models
from heavylift.coordinator.trace import GrantSpan, HeldTime, Lane, Timeline, chains, data, text, trace_events
from heavylift.kernel import RecordingError
from heavylift.recordings import Recorder
from slow_and_quick import TICKS, PAUSE_s

HEAVYLIFT = Path(sys.executable).parent / "heavylift"
SLACK_s = 1e-6  # rounding of sums of nanoseconds


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """`slow` works PAUSE_s at each of its ticks, `quick` hears of each and has ticks of its own in between."""
    path = tmp_path_factory.mktemp("trace") / "run.mcap"
    run_models("slow_and_quick:pair", until=(10 * TICKS + 5) / 1e3, output=path)
    return path


def test_the_trace_of_a_run_shows_that_a_fast_node_waits_for_a_slow_one(file: Path) -> None:
    nodes = {node["node"]: node for node in data(Timeline(file))["nodes"]}
    slow, quick = nodes["slow"], nodes["quick"]
    assert slow["busy_s"] >= TICKS * PAUSE_s
    assert slow["granted_s"] >= slow["busy_s"]
    assert slow["held_s"] == 0  # nobody speaks to it
    assert list(quick["held_by"]) == ["slow"]
    assert quick["held_s"] >= TICKS * PAUSE_s
    assert quick["inputs"] == slow["outputs"] == TICKS


def test_granted_held_and_idle_times_of_each_node_sum_to_the_wall_time(file: Path) -> None:
    found = data(Timeline(file))
    for node in found["nodes"]:
        assert node["granted_s"] + node["held_s"] + node["idle_s"] == pytest.approx(found["wall_s"], abs=SLACK_s)
        assert node["idle_s"] >= -SLACK_s
        assert sum(node["held_by"].values()) == pytest.approx(node["held_s"], abs=SLACK_s)
    assert sum(chain["s"] for chain in found["chains"]) == pytest.approx(
        sum(node["held_s"] for node in found["nodes"]), abs=SLACK_s
    )


def test_traced_intervals_of_a_node_do_not_overlap(file: Path) -> None:
    for lane in Timeline(file).lanes.values():
        spans = sorted((span.begin, span.end) for span in (*lane.grants, *lane.held))
        assert all(begin <= end for begin, end in spans)
        assert all(before[1] <= after[0] for before, after in pairwise(spans))


def test_models_of_one_process_share_a_lane_of_the_trace(tmp_path: Path) -> None:
    run_models("slow_and_quick:pair", until=0.025, output=tmp_path / "run.mcap", in_process=True)
    found = data(Timeline(tmp_path / "run.mcap"))
    assert [(node["node"], node["process"], node["inputs"]) for node in found["nodes"]] == [("slow, quick", "local", 0)]
    assert "pair.slow.out" in [port["port"] for port in found["lookahead"]]


def test_a_chain_of_waiting_nodes_in_the_trace_ends_at_the_node_that_works() -> None:
    timeline = Timeline.__new__(Timeline)
    timeline.lanes = {name: Lane(name, name) for name in "abc"}
    timeline.lanes["a"].held = [HeldTime(0, 100, "b")]
    timeline.lanes["b"].held = [HeldTime(0, 60, "c")]
    timeline.lanes["b"].grants = [GrantSpan(60, 90, 1, 0, 0, 0)]
    timeline.lanes["c"].grants = [GrantSpan(0, 50, 1, 0, 0, 0)]
    assert [(chain.nodes, chain.ns) for chain in chains(timeline)] == [
        (("a", "b", "c"), 50),
        (("b", "c"), 50),
        (("a", "b"), 30),
        (("a", "b", "c", "coordinator"), 10),
        (("a", "b", "coordinator"), 10),
        (("b", "c", "coordinator"), 10),
    ]


def test_the_command_trace_prints_its_results_as_tables(file: Path) -> None:
    lines = text(Timeline(file)).splitlines()
    assert lines[0].endswith("no node was granted: the coordinator decided or recorded")
    assert [line.split()[0] for line in lines[3:5]] == ["slow", "quick"]
    assert lines[4].endswith("slow 100 %")
    assert any(line.endswith("quick <- slow at work") for line in lines)
    assert any("ports would have kept a longer lookahead" in line for line in lines)
    assert any(line.split()[:3] == ["pair.slow.out", "0", "10"] for line in lines), lines


def test_a_trace_viewer_reads_the_exported_trace(file: Path) -> None:
    """The rules of the Trace Event Format that viewers rely on."""
    trace = json.loads(json.dumps(trace_events(Timeline(file))))
    events = trace["traceEvents"]
    assert all({"name", "ph", "ts", "pid", "tid"} <= event.keys() for event in events)
    assert {event["ph"] for event in events} == {"M", "X", "s", "f", "C"}
    assert [event["ts"] for event in events] == sorted(event["ts"] for event in events)
    assert all(isinstance(event["pid"], int) and isinstance(event["tid"], int) for event in events)

    named = {(e["pid"], e["tid"]): e["args"]["name"] for e in events if e["name"] == "thread_name"}
    slices: dict[tuple[int, int], list[tuple[float, float]]] = {}
    for event in events:
        if event["ph"] == "X":
            assert event["dur"] >= 0
            slices.setdefault((event["pid"], event["tid"]), []).append((event["ts"], event["ts"] + event["dur"]))
    assert set(named.values()) == {"decides and records", "slow", "quick"}
    assert slices.keys() == named.keys()
    near = 1e-6  # [us] rounding of ts + dur
    for spans in slices.values():  # one after the other, so that none covers another one partly
        assert all(before[1] <= after[0] + near for before, after in pairwise(sorted(spans)))

    arrows: dict[str, list[dict[str, object]]] = {}
    for event in events:
        if event["ph"] in "sf":
            arrows.setdefault(event["id"], []).append(event)
            spans = slices[event["pid"], event["tid"]]
            assert any(begin - near <= event["ts"] <= end + near for begin, end in spans), event
    assert all(sorted(str(end["ph"]) for end in ends) == ["f", "s"] for ends in arrows.values())
    assert len(arrows) == 2 * sum(event["name"] == "granted" for event in events)
    assert all(isinstance(v, int | float) for e in events if e["ph"] == "C" for v in e["args"].values())


def test_the_trace_command_prints_tables_and_writes_a_file(file: Path, tmp_path: Path) -> None:
    command = [HEAVYLIFT, "trace", file, "--json", "--perfetto", tmp_path / "trace.json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    assert json.loads(done.stdout) == data(Timeline(file))
    assert json.loads((tmp_path / "trace.json").read_text()) == trace_events(Timeline(file))


def test_a_recording_without_protocol_messages_has_no_trace(tmp_path: Path) -> None:
    with Recorder(tmp_path / "empty.mcap", {"nodes": ["a"]}):
        pass
    with pytest.raises(RecordingError, match="has no GRANT"):
        Timeline(tmp_path / "empty.mcap")
