"""The models of a lift: machines and their commander, made from a plan.

build(plan), build_one(plan, name)     the coupled model of each node
divided(plan, nodes)                   what each node needs of a plan
system(plan)                           what they declare together, for the kernel
couplings(plan), subscriptions(plan)   how nodes and kernel are wired, who hears which state event
tree(plan), tree_data(plan)            the model tree as text, as plain data

machine                                any machine, walked from its parts
levels                                 how much of a machine is modelled: passes over its description
user_models                                    a user's own model beside the kernel: Sample in, SetPoint out
assembly, tree                         from a plan to models and couplings; their tree as text
parts                                  what machines are made of: drives, gauges, slings, brakes; messages
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

__all__ = [
    "COMMANDER", "KERNEL", "CommanderModel", "NodeModel", "Sample", "SetPoint", "UserModelNode", "build", "build_one",
    "couplings", "divided", "driving", "goes_on", "hooked_later", "node_names", "sample_port", "subscriptions",
    "system", "together", "tree", "tree_data",
]  # fmt: skip

face(__name__)
