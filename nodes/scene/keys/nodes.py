"""The keys for the nodes of a run: `models` of users beside the kernel, and `placement` of nodes in processes.

models:
  damper:
    model: anti_sway.py:Damper                      in the folder of the scene; or module:name, or unit.fmu
    period: 100 ms                                  of samples
    signals: {swing: swing along of fall-1}         in port: its signal
    orders: {speed: trolley}                        out port: the drive or winch that its set-points lead
    parameters: {gain: 12 m/s}                      quantities arrive in SI units

placement:
  yard-a: [west, block]                             two nodes share a process
  yard-b: {nodes: [east], host: remote}             started on another host, by `heavylift node yard-b`

Nodes are the machines of the scene, `commander` and `kernel`; those that are not named have a process of their own.
"""

from collections.abc import Mapping, Sequence
from typing import Annotated, Literal

from heavylift.nodes.scene.text import units as u
from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Fault, SourceText
from heavylift.nodes.scene.text.spelling import number_and_unit
from pydantic import BeforeValidator, Field, model_validator

from .base import Base, Name


def _parameter(given: object) -> object:
    """Return a parameter; a quantity is converted to SI units, other texts, numbers and booleans are returned
    unchanged."""
    if isinstance(given, str) and (unit := number_and_unit(given)[1]):
        for dimension in u.DIMENSIONS:
            if unit in dimension.units:
                return dimension.read(given)
    if isinstance(given, int) and not isinstance(given, bool):
        return float(given)
    if not isinstance(given, float | bool | str):
        raise ValueError("write a number, a quantity, a word, true or false here")
    return given


Parameter = Annotated[float | bool | str, BeforeValidator(_parameter)]


class ModelKeys(Base):
    """Keys of a user's model: the signals that it samples, and the actuators that its set-points control.

    Set-points act after the time `delay`."""

    model: str  # module:name, or file.py:name or unit.fmu in the folder of the scene
    period: u.Duration  # of samples; of a unit of FMI its step
    delay: u.Delay = 0.0  # 0: the mechanics wait for it at each sample
    signals: dict[Name, str] = Field(
        default_factory=dict
    )  # in port: what it hears, such as `height of block`, `load of crane H1 in %`
    orders: dict[Name, str] = Field(default_factory=dict)  # out port: the drive or winch that its set-points lead
    parameters: dict[str, Parameter] = Field(default_factory=dict)  # quantities arrive in SI units


class Process(Base):
    """A process of a run: its nodes, and the host on which it is started."""

    nodes: Annotated[list[str], Field(min_length=1)]
    host: Literal["here", "remote"] = "here"

    @model_validator(mode="before")
    @classmethod
    def _list(cls, data: object) -> object:
        return {"nodes": data} if isinstance(data, list) else data


def placement_faults(source: SourceText, placement: Mapping[str, Process], nodes: Sequence[str]) -> list[Fault]:
    """Return the errors of a placement: unknown nodes, and nodes that are placed twice."""
    found, placed = list[Fault](), dict[str, str]()
    for process, hosting in placement.items():
        given = source.at(("placement", process))
        below = ("placement", process) if isinstance(given, list) else ("placement", process, "nodes")
        for i, node in enumerate(hosting.nodes):
            if node not in nodes:
                found.append(Fault((*below, i), f"there is no node '{node}'", closest(node, nodes)))
            elif node in placed:
                found.append(Fault((*below, i), f"node '{node}' is placed twice, in '{placed[node]}' before"))
            placed.setdefault(node, process)
    return found
