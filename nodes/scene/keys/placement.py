"""The key `placement` of a scene: which process hosts which nodes, and which processes run on another host.

    placement:
      yard-a: [west, loader-1]                    two nodes share a process
      yard-b: {nodes: [east], host: remote}       a process that is started on another host, by `heavylift node yard-b`

Nodes are the machines of the scene, `commander` and `kernel`; those that are not named have a process of their own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Literal

from heavylift.nodes.scene.text.faults import closest
from heavylift.nodes.scene.text.source import Fault, Source
from pydantic import Field, model_validator

from .base import Base

__all__ = ["Process", "placement_faults"]


class Process(Base):
    """A process of a run: its nodes, and whether it is started here or on another host."""

    nodes: Annotated[list[str], Field(min_length=1)]
    host: Literal["here", "remote"] = "here"

    @model_validator(mode="before")
    @classmethod
    def _list(cls, data: object) -> object:
        return {"nodes": data} if isinstance(data, list) else data


def placement_faults(source: Source, placement: Mapping[str, Process], nodes: Sequence[str]) -> list[Fault]:
    """Names that are no nodes, and nodes that are placed twice."""
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
