"""A scene that a controller steps, for learning: `reset`, `step`, `observe`.

env = Environment("trolley", ["drive"], ["joint/position/*", "pose/load/x"], period=0.1)
env.reset()
while not env.over:
    seen = env.step([0.3])                     # speeds of the drives until the next step
"""

from collections.abc import Sequence
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np
from heavylift.coordinator.ladder.choosing import chosen
from heavylift.coordinator.run.arguments import PERIOD, patterns, time_s
from heavylift.kernel.errors import SceneError
from heavylift.nodes.devs import seconds
from heavylift.nodes.scene import LoadedScene, loaded
from numpy.typing import NDArray

from .exporting import masters_of
from .scene_unit import led
from .steppable_run import SteppableRun


class Environment:
    """A scene in which a controller sets speeds of drives, winches and wind every `period` [s].

    `actions`: the names of these; speeds are in m/s or rad/s.

    `names`: the observed signals, as `simulate` names them, that match the patterns `observations`.
    """

    def __init__(
        self,
        scene: LoadedScene | str | Path,
        actions: Sequence[str] = (),
        observations: Sequence[str] = ("joint/position/*", "joint/velocity/*"),
        period: float = 0.1,
    ) -> None:
        """Load the scene and reset it; raises HeavyliftError for unknown actions or observations."""
        found = chosen(loaded(scene))
        own, wind = masters_of(found, actions)
        self._plan, self._period = led(found.plan, own, wind), seconds(time_s("period", period, PERIOD))
        moved = (x.move.actuator for model in own for x in model.leads)
        self._actuators = ["wind" if name == "wind" else next(moved) for name in actions]
        self._wanted = patterns(observations)
        self.reset()

    def reset(self) -> NDArray[np.float64]:
        """Restart the scene at rest at 0 s; return the observation (n,)."""
        self._run = SteppableRun(self._plan, lambda words: b"")
        self.names = [x for x in self._run.columns if any(fnmatchcase(x, wanted) for wanted in self._wanted)]
        if not self.names:
            raise SceneError(f"observations={self._wanted!r}: no signal matches; give names as `simulate` lists them")
        return self.observe()

    @property
    def t(self) -> float:
        """The present simulation time [s]."""
        return self._run.now / 1e9

    @property
    def over(self) -> bool:
        """Whether the next step would pass the end time of the scene."""
        return self._run.now + self._period > self._run.end

    def observe(self) -> NDArray[np.float64]:
        """Return the observed signals (n,) now, in SI units."""
        return np.array([self._run[name] for name in self.names])

    def step(self, action: Sequence[float]) -> NDArray[np.float64]:
        """Advance by one period with these speeds of the actions and return the observation (n,); raises ModelError
        beyond the end."""
        for name, speed in zip(self._actuators, action, strict=True):
            if name == "wind":
                self._run.set_wind(float(speed))
            else:
                self._run.set_speed(name, float(speed))
        self._run.go(self._run.now + self._period)
        return self.observe()
