"""A scene as a slave of FMI 3.0 with event mode and early return, by pythonfmu3.

If the master uses event mode and allows early returns, a step ends at the first event in it, rounded up to the
nanosecond: outputs are those before the event, and after the update of event mode those after it. pythonfmu3 does not
pass early returns on; the small C library `early_return.c`, compiled by the export, does.
"""

import shutil
import subprocess
import zipfile
from collections import namedtuple
from functools import partial
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

from heavylift.kernel.errors import ModelError
from heavylift.nodes.devs import seconds
from heavylift.recordings.format.text import GENERATOR
from pythonfmu3 import DefaultExperiment, Float64, Fmi3Causality, Fmi3Slave, Fmi3Variability, FmuBuilder, String
from pythonfmu3.enums import Fmi3Status
from pythonfmu3.fmi3slave import Fmi3StepResult

from .scene_unit import SteppedScene
from .unit_definitions import with_units

FOLDER, LIBRARY = "binaries/x86_64-linux", "libpythonfmu3export.so"
SHARED = "libpythonfmu-export.so"  # its name before, which is also that of pythonfmu: a process would load only one
LOCAL = ("step.stops_at_events", "step.met_event", "step.ended_early", "step.time")  # as `early_return.c` reads them
VARIABILITY = {"parameter": Fmi3Variability.fixed, "input": Fmi3Variability.continuous}
Updated = namedtuple(
    "Updated",
    "discreteStatesNeedUpdate terminateSimulation nominalContinuousStatesChanged "
    "valuesOfContinuousStatesChanged nextEventTimeDefined nextEventTime",
)


class SceneUnit3(Fmi3Slave):  # type: ignore[misc]
    """The FMI 3.0 slave in an exported FMU, which simulates the scene stored next to its module."""

    def __init__(self, **given: object) -> None:
        super().__init__(**given)
        self._of = SteppedScene(Path(str(self.resources)))
        plan = self._of.plan
        self.author, self.description = GENERATOR, f"the scene {plan.name}"
        self.default_experiment = DefaultExperiment(0.0, plan.end, 1 / plan.samples_hz, plan.tolerance)
        self._step = dict.fromkeys(LOCAL, 0.0)
        local = {"causality": Fmi3Causality.local, "variability": Fmi3Variability.discrete}
        for name in LOCAL:
            take = {"getter": partial(self._step.__getitem__, name), "setter": partial(self._step.__setitem__, name)}
            self._register(Float64(name, **take, **local))
        of_time = {"causality": Fmi3Causality.independent, "variability": Fmi3Variability.continuous}
        self._register(Float64("time", getter=lambda: self._of.run.now / 1e9, **of_time))
        made = self._of.declared(String, Float64, Fmi3Causality, Fmi3Variability.discrete, VARIABILITY)
        for variable in made:
            self._register(variable)
        self._units = {x.name: x.unit for x in self._of.variables()}

    def _register(self, variable: object) -> None:
        self.register_variable(variable, nested=False)

    def to_xml(self, *given: Any, **more: Any) -> Element:
        """Return the model description with event mode, early returns, units, and names with hyphens."""
        root: Element = super().to_xml(*given, **more)
        root.set("variableNamingConvention", "flat")
        simulated = next(root.iter("CoSimulation"))
        simulated.attrib |= {"hasEventMode": "true", "mightReturnEarlyFromDoStep": "true"}
        variables = {x.get("name", ""): x for x in next(root.iter("ModelVariables"))}
        return with_units(root, {name: variables[name] for name in self._units}, self._units)

    def setup_experiment(self, start_time: float, stop_time: float | None = None, *more: object) -> None:
        """Set start and end of the experiment [s]."""
        self._of.start(start_time, stop_time)

    def exit_initialization_mode(self) -> None:
        """Begin the run with the parameters that were set."""
        self._of.ready()

    def update_discrete_states(self) -> Updated:
        """Update the outputs after the events at which a step has ended; no further update is needed."""
        self._of.run.settle()
        return Updated(False, False, False, False, False, 0.0)

    def do_step(self, current_time: float, step_size: float) -> Fmi3StepResult:
        """Make one communication step [s], up to the first event if the master stops at events."""
        end, stops = current_time + step_size, self._step[LOCAL[0]] != 0.0
        met = self._of.step(end, lambda why: self.log(why, Fmi3Status.error), stops)
        if met is None:
            return Fmi3StepResult(Fmi3Status.discard)
        early = met and self._of.run.now < seconds(end)
        reached = self._of.run.now / 1e9 if early else end
        self._step |= dict(zip(LOCAL[1:], (float(met), float(early), reached), strict=True))
        return Fmi3StepResult(Fmi3Status.ok)

    def _get_fmu_state(self) -> dict[str, Any]:
        return self._of.state()

    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        self._of.restore(state)


def build(code: Path, made: Path, data: Path, options: dict[str, bool]) -> None:
    """Build the FMU file from a slave's code and its data; raises ModelError if there is no C compiler."""
    compiler = shutil.which("cc")
    if compiler is None:
        raise ModelError("an FMU for FMI 3 needs a C compiler, 'cc': install one, or make an FMU for FMI 2")
    plain = FmuBuilder.build_FMU(code, dest=made.parent / "plain", project_files=[data], **options)
    source, library = Path(__file__).with_name("early_return.c"), made.with_suffix(".so")
    with zipfile.ZipFile(plain) as old, zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as new:
        of_pythonfmu = made.parent / LIBRARY
        of_pythonfmu.write_bytes(old.read(f"{FOLDER}/{plain.stem}.so").replace(SHARED.encode(), LIBRARY.encode()))
        flags = ["-O1", "-s", "-shared", "-fPIC", "-Wl,-rpath,$ORIGIN", "-Wl,--no-as-needed"]
        called = [compiler, *flags, str(source), str(of_pythonfmu), "-o", str(library), "-ldl"]
        compiled = subprocess.run(called, capture_output=True, text=True, cwd=made.parent)
        if compiled.returncode:
            raise ModelError(f"the C compiler cannot build the library of the FMU: {compiled.stderr.strip()[:300]}")
        for entry in old.namelist():
            if not entry.startswith("binaries/"):
                new.writestr(entry, old.read(entry))
        new.write(of_pythonfmu, f"{FOLDER}/{LIBRARY}")
        new.write(library, f"{FOLDER}/{plain.stem}.so")
