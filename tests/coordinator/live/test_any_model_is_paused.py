"""A run of any DEVS model can be watched, paused and stepped; what its models cannot be reported is refused at once."""

import signal
from itertools import islice
from pathlib import Path

import pytest
from heavylift.coordinator.live import RunOrder, observe, order
from heavylift.kernel import HeavyliftError
from running import PATIENCE_s, found, going

RING = Path(__file__).parents[2] / "coordinator/participants" / "rings.py"


def test_a_run_of_any_devs_model_can_be_paused_and_stepped(tmp_path: Path) -> None:
    with going(tmp_path, "devs", f"{RING}:tokens", "-o", "ring.mcap") as process:
        run = found(tmp_path / "ring.mcap")
        assert len(list(islice(observe(run), 3))) == 3
        paused = float(order(run, RunOrder("pause")).split()[2])
        assert order(run, RunOrder("step", by_ns=10**9)) == f"paused at {paused + 1:.9f} s"
        for what in (RunOrder("command", text="a: b"), RunOrder("stop")):
            with pytest.raises(HeavyliftError, match="no model of this run takes commands"):
                order(run, what)
        assert order(run, RunOrder("continue")) == "goes on"
        process.send_signal(signal.SIGINT)
        _, error = process.communicate(timeout=PATIENCE_s)
    assert process.returncode == 130
    assert error.startswith("heavylift: stopped by the user at ")
