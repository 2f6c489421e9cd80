"""A yard that runs is watched like any run."""

import os
import signal
import sys
from pathlib import Path

from heavylift.coordinator.live import observe
from heavylift.recordings import Recording

sys.path.insert(0, str(Path(__file__).parent.parent / "live"))
from running import PATIENCE_s, found, going

YARD = """
heavylift yard: 1
start: 2027-01-04
resources: {crane: 1}
blocks: {from: blocks.csv}
steps: {erect: {takes: 4 h, needs: {crane: 1}}, weld: {takes: 30 h, after: erect}}
"""


def test_an_observer_of_a_yard_sees_each_event_once_and_in_order(tmp_path: Path) -> None:
    (tmp_path / "yard.yaml").write_text(YARD)
    (tmp_path / "blocks.csv").write_text("block\n" + "".join(f"B{n}\n" for n in range(20)))
    with going(tmp_path, "run", "yard.yaml", "--processes", "2") as process:
        run = found(tmp_path / "yard.mcap")
        os.kill(process.pid, signal.SIGSTOP)  # until somebody watches
        observer = observe(run)
        os.kill(process.pid, signal.SIGCONT)
        seen = [(e.t, e.k, e.source, e.port, e.index) for _, e in observer]
        assert process.wait(PATIENCE_s) == 0
    told = [(e.t_ns, e.microstep, e.source, e.port, e.index) for e in Recording(tmp_path / "yard.mcap").events()]
    assert seen == told
    assert sum(source == "step-weld" for _, _, source, *_ in seen) == 20
