"""A mass on a spring as a unit of FMI; imported where the unit is built, by pythonfmu."""

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real


class Spring(Fmi2Slave):
    """x'' = (f - x) / m from x = 1, ten semi-implicit steps in one."""

    def __init__(self, **given: object) -> None:
        super().__init__(**given)
        self.f, self.x, self.v, self.m, self.steps = 0.0, 1.0, 0.0, 1.0, 0
        self.register_variable(Real("f", causality=Fmi2Causality.input))
        self.register_variable(Real("x", causality=Fmi2Causality.output))
        self.register_variable(Real("v", causality=Fmi2Causality.local))
        self.register_variable(Integer("steps", causality=Fmi2Causality.output, variability=Fmi2Variability.discrete))
        mass = Real("m", causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable, start=1.0)
        self.register_variable(mass)

    def do_step(self, t: float, h: float) -> bool:
        for _ in range(10):
            self.v += h / 10 * (self.f - self.x) / self.m
            self.x += h / 10 * self.v
        self.steps += 1
        return True
