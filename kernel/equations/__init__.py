"""The equations of motion of a scene in print, as text or as a LaTeX document: `heavylift equations SCENE`.

document                 formulas in both notations; sections laid out
bodies                   eqs (1)-(4) of every body; the recursion of Fig. 6; columns of S, joint forces
laws                     every law with its formula and numbers
coordinates              what is solved; the traced text itself, every quantity named
"""

from heavylift.kernel.description.mechanics import WORLD, System
from heavylift.kernel.multibody.graph import Graph, build_graph

from .bodies import balances, joints, recursion
from .coordinates import coordinates
from .document import DocumentSection, as_latex, as_text, formulation_section
from .laws import laws

__all__ = ["equations"]


def equations(
    system: System, formulation: str = "recursive", latex: bool = False, title: str = "Equations of motion"
) -> str:
    """Return all equations of motion of a system as text or LaTeX; raises KernelError for an invalid system."""
    graph = build_graph(system)
    sections = [
        _graph(graph), _path_matrix(graph), balances(system, graph), joints(system, graph), *laws(system),
        recursion(graph), formulation_section(graph, formulation), coordinates(system, formulation),
    ]  # fmt: skip
    return as_latex(sections, title) if latex else as_text(sections)


def _graph(graph: Graph) -> DocumentSection:
    rows = [("", "body", "joint", "kind", "on")]
    for i, k in enumerate(graph.links):
        parent = WORLD if k.parent < 0 else graph.links[k.parent].body.name
        rows.append((str(i + 1), k.body.name, k.joint.name, k.joint.kind, parent))
    rows += [("-", j.child, j.name, j.kind, f"{j.parent} (closes a loop)") for j in graph.loops]
    return DocumentSection("graph", table=tuple(rows))


def _path_matrix(graph: Graph) -> DocumentSection:
    matrix = tuple(tuple(str(x) for x in row) for row in graph.T)
    return DocumentSection(
        "path matrix", ("T[k, i] = 1: joint i lies on the path from the ground to body k",), matrix=matrix
    )
