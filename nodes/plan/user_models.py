"""Models written by users that run beside the kernel: their signals, the controlled actuators, and the delay."""

import msgspec
from heavylift.kernel.description.signals import ScalarSignal

from .actions import Item, Move


class Led(Item, frozen=True, kw_only=True):
    """An output port of a user model whose set-points control the speed of an actuator.

    The actuator makes an endless move with a ramp and a maximum speed (0: unknown)."""

    port: str
    move: Move


class UserModel(Item, frozen=True, kw_only=True):
    """A user's model that runs as a node.

    `model` is `module:name`, an absolute path `file.py:name`, or the path of an FMU. The model receives its `signals`,
    one for each port, every `period` [ns]; its set-points take effect `delay` [ns] later."""

    name: str
    model: str
    period: int
    delay: int = 0
    signals: dict[str, ScalarSignal] = msgspec.field(default_factory=dict)
    leads: tuple[Led, ...] = ()
    parameters: dict[str, float | str | bool] = msgspec.field(default_factory=dict)

    @property
    def unit(self) -> bool:
        """Whether the user model is an FMU (a functional mock-up unit)."""
        return self.model.endswith(".fmu")

    @property
    def reference(self) -> str:
        """The reference to the model's code, in the form that is checked against trusted folders."""
        return f"{self.model}:" if self.unit else self.model
