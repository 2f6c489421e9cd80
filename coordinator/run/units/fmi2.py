"""A scene as a slave of FMI 2.0, by pythonfmu.

A step beyond the end of the scene or of the experiment, back in time, or after a failure is discarded, with the reason
in the log: with fmi2Discard a slave ends early (FMI 2.0.4, section 4.2.2), and fmi2LastSuccessfulTime is the start of
the step, no part of which was executed. pythonfmu has no other refusal: an exception becomes fmi2Fatal, after which a
master may not even free the unit, and the inquiry fmi2Terminated returns fmi2Error in every unit that it makes.
"""

from copy import deepcopy
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

from heavylift.recordings.format.text import GENERATOR
from pythonfmu import DefaultExperiment, Fmi2Causality, Fmi2Slave, Fmi2Variability, Real, String
from pythonfmu.enums import Fmi2Status

from .scene_unit import SteppedScene
from .unit_definitions import with_units

VARIABILITY = {"parameter": Fmi2Variability.fixed}


class SceneUnit(Fmi2Slave):  # type: ignore[misc]
    """The FMI 2.0 slave in an exported FMU, which simulates the scene stored next to its module."""

    def __init__(self, **given: object) -> None:
        super().__init__(**given)
        self._of = SteppedScene(Path(str(self.resources)))
        plan = self._of.plan
        self.author, self.description = GENERATOR, f"the scene {plan.name}"
        self.default_experiment = DefaultExperiment(0.0, plan.end, 1 / plan.samples_hz, plan.tolerance)
        made = self._of.declared(String, Real, Fmi2Causality, Fmi2Variability.discrete, VARIABILITY)
        for variable in made:
            self._register(variable)
        self._units = {x.name: x.unit for x in self._of.variables()}

    def _register(self, variable: object) -> None:
        self.register_variable(variable, nested=False)

    def to_xml(self, *given: Any, **more: Any) -> Element:
        """Return the model description written by pythonfmu, with units, hyphenated names and initially unknown
        outputs added."""
        root: Element = super().to_xml(*given, **more)
        root.set("variableNamingConvention", "flat")
        for structure in root.iter("ModelStructure"):
            structure.extend([deepcopy(node) for node in structure])
            structure[-1].tag = "InitialUnknowns"
        variables = {x.get("name", ""): x for x in root.iter("ScalarVariable")}
        return with_units(root, {name: variables[name][0] for name in self._units}, self._units)

    def setup_experiment(self, start_time: float, stop_time: float | None, tolerance: float | None) -> None:
        """Set start and end of the experiment [s]."""
        self._of.start(start_time, stop_time)

    def exit_initialization_mode(self) -> None:
        """Begin the run with the parameters that were set."""
        self._of.ready()

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Make one communication step [s]; returns False if the step is discarded, with the reason in the log."""
        return self._of.step(current_time + step_size, lambda why: self.log(why, Fmi2Status.error)) is not None

    def _get_fmu_state(self) -> dict[str, Any]:
        return self._of.state()

    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        self._of.restore(state)
