"""How many steps a lift may take in no time is a key of its scene."""

import pytest
from heavylift.coordinator.run import run
from heavylift.kernel import ModelError, SceneError
from heavylift.nodes.devs import Simulator
from heavylift.nodes.scene import load

LONGER = "or allow more microsteps (a scene's key microsteps, heavylift devs --microsteps)"


def test_exceeding_the_microstep_limit_of_a_scene_ends_the_run(tmp_path):
    with pytest.raises(ModelError) as error:
        run(load("lift", ["microsteps=1"]), tmp_path / "lift.mcap", in_process=True)
    assert str(error.value) == (
        "crane at (0 s, 1): port input has spoken at 1 microsteps in which no time passes; "
        f"let it hold for more than 0 ns, {LONGER}"
    )


def test_each_model_of_a_scene_has_the_microstep_limit_stated_in_the_scene(tmp_path, monkeypatch):
    seen = set()

    def start(self, before=Simulator.start):
        seen.add(self._patience.microsteps)
        before(self)

    monkeypatch.setattr(Simulator, "start", start)
    run(load("pendulum", ["microsteps=77", "end=1 s"]), tmp_path / "pendulum.mcap", in_process=True)
    assert seen == {77}


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ("0", "1 or more is needed here, not 0"),
        ("2147483648", "2147483647 or less is needed here, not 2147483648"),
        ("2.5", "a whole number is needed here"),
        ("many", "a whole number is needed here"),
    ],
)
def test_an_invalid_microstep_limit_in_a_scene_is_refused(given, told):
    with pytest.raises(SceneError, match=f"error: microsteps: {told}\n"):
        load("pendulum", [f"microsteps={given}"])
