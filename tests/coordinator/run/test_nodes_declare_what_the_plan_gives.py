"""The kernel starts with the mechanics of the plan; models that declare others end the run."""

from dataclasses import replace
from pathlib import Path

import pytest
from heavylift.coordinator.run import run, scene
from heavylift.kernel import ProtocolError
from heavylift.nodes.models import NodeModel
from heavylift.nodes.plan import Plan
from heavylift.nodes.scene import load


def test_a_run_ends_with_the_name_of_a_node_that_declares_other_mechanics(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lift, build = load("lift", ["end=2 s", "ask=[]"]), scene.build
    name = lift.plan.machines[0].name

    def other(plan: Plan) -> dict[str, NodeModel]:
        models = build(plan)
        declared = models[name].declare
        monkeypatch.setattr(
            models[name],
            "declare",
            lambda: replace(declared(), bodies=tuple(replace(b, mass=2.0 * b.mass) for b in declared().bodies)),
        )
        return models

    monkeypatch.setattr(scene, "build", other)
    with pytest.raises(ProtocolError, match=f"node .*{name}.* declares other mechanics"):
        run(lift, tmp_path / "lift.mcap", in_process=True)
