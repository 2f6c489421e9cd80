"""The models of a lift: machines and their commander, built from a plan.

build(plan), build_one(plan, name)     the coupled model of each node
divided(plan, nodes)                   the part of a plan that each node needs
system(plan)                           the mechanics declared by all nodes, for the kernel
taken_over(models, old, new)           models of a plan taken over by one of equal structure
couplings(plan), subscriptions(plan)   couplings of nodes and kernel; nodes that receive each state event
tree(plan), tree_data(plan)            the model tree as text, as plain data

machine                                any machine, built from its parts
levels                                 model levels of a machine: passes over its description
user_models                            a user's own model beside the kernel: Sample in, SetPoint out
assembly, tree, variants               models and couplings from a plan; their tree as text; models taken over
parts                                  parts of machines: drives, gauges, slings, brakes; messages
commander                              carries out the action list
"""

from heavylift.kernel.on_demand import face
from heavylift.nodes.models.commander.actuator_registry import hooked_later

from .assembly import (
    COMMANDER,
    KERNEL,
    CommanderModel,
    NodeModel,
    build,
    build_one,
    couplings,
    divided,
    driving,
    goes_on,
    node_names,
    subscriptions,
    system,
    together,
)
from .parts.messages import Sample, SetPoint
from .tree import tree, tree_data
from .user_models import UserModelNode, sample_port
from .variants import taken_over

__all__ = [
    "COMMANDER", "KERNEL", "CommanderModel", "NodeModel", "Sample", "SetPoint", "UserModelNode", "build", "build_one",
    "couplings", "divided", "driving", "goes_on", "hooked_later", "node_names", "sample_port", "subscriptions",
    "system", "taken_over", "together", "tree", "tree_data",
]  # fmt: skip

face(__name__)
