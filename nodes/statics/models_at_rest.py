"""The DEVS models of a scene for static runs, which plans of equal structure hand on to each other."""

from contextlib import suppress

from heavylift.nodes.devs import Coupled, Out, Simulator
from heavylift.nodes.models import COMMANDER, KERNEL, CommanderModel, build, couplings, taken_over
from heavylift.nodes.models.parts import messages as m
from heavylift.nodes.plan.plan import Plan

MOST_SPARE = 3  # of a scene, of its corners, of a variant


class Models(Coupled):
    """All models of a scene except the kernel, connected to each other for a static calculation."""

    stage = Out(m.Stage)
    finished = Out(m.Finished)

    def __init__(self, plan: Plan) -> None:
        super().__init__(plan.name)
        self.plan, self.models = plan, build(plan)
        for model in self.models.values():
            self.add(model)
        for source, out, target, into in couplings(plan):
            if target == KERNEL:
                self.connect(self.models[source].ports[out], self.add_out(into, m.KernelInput))
            elif source == KERNEL:
                self.connect(self.add_in(out, m.StateEvent), self.models[target].ports[into])
            else:
                self.connect(self.models[source].ports[out], self.models[target].ports[into])
        self.connect(self.commander.stage, self.stage)
        self.connect(self.commander.finished, self.finished)

        # output functions are checked for purity in runs; here each costs time only
        self.simulator = Simulator(self, microsteps=plan.microsteps, watched=False)

    @property
    def commander(self) -> CommanderModel:
        """The model of the commander, which executes the action list."""
        model = self.models[COMMANDER]
        assert isinstance(model, CommanderModel)
        return model

    @classmethod
    def of(cls, plan: Plan) -> "Models":
        """Return models of a plan: spare ones that fit it, or new ones; no two threads get the same spare models."""
        for _ in range(len(_SPARE)):
            with suppress(IndexError):
                models = _SPARE.pop(0)
                if taken_over(models.models, models.plan, plan):
                    models.plan = plan
                    return models
                _SPARE.append(models)
        return cls(plan)

    def give_back(self) -> None:
        """Leave the models to the next static run; the run that has used them must not use them again."""
        _SPARE[MOST_SPARE - 1 :] = []
        _SPARE.insert(0, self)


_SPARE: list[Models] = []  # of static runs that are over
