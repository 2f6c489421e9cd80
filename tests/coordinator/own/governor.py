"""A unit of FMI that leads a drive: proportional to what it hears, a step late as all units are."""

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class Governor(Fmi2Slave):
    author = "heavylift"

    def __init__(self, **kwargs: object) -> None:
        super().__init__(**kwargs)
        self.x = self.speed = self.sum = 0.0
        self.goal, self.gain = 0.2, 0.5
        self.register_variable(Real("x", causality=Fmi2Causality.input))
        for name in ("goal", "gain"):
            given = {"causality": Fmi2Causality.parameter, "variability": Fmi2Variability.tunable}
            self.register_variable(Real(name, start=getattr(self, name), **given))
        self.register_variable(Real("speed", causality=Fmi2Causality.output))

    def do_step(self, current_time: float, step_size: float) -> bool:
        self.sum += step_size * (self.goal - self.x)
        self.speed = self.gain * (self.goal - self.x) + 0.01 * self.sum
        return True
