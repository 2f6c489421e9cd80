"""User models beside the kernel: their signals, the actuators that they lead, their delay."""

import msgspec
from heavylift.kernel.description.signals import ScalarSignal

from .actions import Item, Move


class Led(Item, frozen=True, kw_only=True):
    """An out port whose set-points drive an actuator: an endless move with ramp and maximum speed (0: unknown)."""

    port: str
    move: Move


class UserModel(Item, frozen=True, kw_only=True):
    """A user model that runs as a node; `model` is `module:name`, an absolute path `file.py:name`, or that of an FMI
    unit. It receives its `signals`, by port, every `period` [ns]; its set-points arrive `delay` [ns] later."""

    name: str
    model: str
    period: int
    delay: int = 0
    signals: dict[str, ScalarSignal] = msgspec.field(default_factory=dict)
    leads: tuple[Led, ...] = ()
    parameters: dict[str, float | str | bool] = msgspec.field(default_factory=dict)

    @property
    def unit(self) -> bool:
        """Whether it is an FMU."""
        return self.model.endswith(".fmu")

    @property
    def reference(self) -> str:
        """The reference as it is checked against trusted folders."""
        return f"{self.model}:" if self.unit else self.model
