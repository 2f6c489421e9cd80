"""The kernel starts with the mechanics of the plan; models that declare others end the run."""

from dataclasses import replace
from pathlib import Path

import msgspec
import pytest
from heavylift.coordinator.run import run, scene
from heavylift.kernel import ProtocolError
from heavylift.nodes.models import NodeModel, build
from heavylift.nodes.plan import Plan, decode, encode
from heavylift.nodes.scene import bundled, load


def test_a_run_ends_with_the_name_of_a_node_that_declares_other_mechanics(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lift, built = load("lift", ["end=2 s", "ask=[]"]), scene.build
    name = lift.plan.machines[0].name

    def other(plan: Plan) -> dict[str, NodeModel]:
        models = built(plan)
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


@pytest.mark.parametrize("name", sorted(bundled()))
def test_models_of_a_plan_that_was_sent_to_a_node_declare_the_same_bytes(name: str) -> None:
    plan = load(name).plan
    here, there = (
        [msgspec.msgpack.encode(model.declare()) for model in build(each).values()]
        for each in (plan, decode(encode(plan)))
    )
    assert here == there
