"""Texts of the comparison page besides its rows: tables, introductions, other codes, sources searched for."""

from __future__ import annotations

import ast

from comparison import TESTS

TABLES = {
    "Swing": "",
    "Hoisting": "",
    "Statics": "",
    "What goes wrong in a lift": "",
    "Beams": "",
    "Rotating bodies and joints": "",
    "Springs, stops, brakes": "",
    "Contact and friction": "",
    "Numerical methods": "",
    "Design factors": "Factors of standards are conservative; ours must not exceed them for a slow lift.",
    "Worked examples of rules and tools": (
        "The printed result of the first could not be read: theirs is the printed formula with the printed inputs."
    ),
    "Published problems": (
        "Where the source does not publish the figure itself, theirs is the project's own solution with 113 bits, "
        "confirmed by a second method."
    ),
    "Published measurements": (
        "*Within* is the stated uncertainty of the measurement. Inputs (motion of the trolley, lengths, masses) are "
        "measured, too; nothing is fitted."
    ),
}

OTHER_CODES = (  # what, which code, file, the constant in it that bounds the difference, of what
    ("accelerations of random trees", "Pinocchio", "kernel/multibody/test_random_trees_agree_with_pinocchio", "SAME", "relative"),  # noqa: E501
    ("every kind of joint, alone and in trees", "Pinocchio, MuJoCo", "kernel/multibody/test_every_joint_agrees_with_others",  # noqa: E501
     "SAME", "relative"),
    ("random trees with loops", "Pinocchio", "kernel/constraints/test_loops_close", "AGREES", "relative"),
    ("ropes between bodies", "MuJoCo", "kernel/forces/ropes/test_ropes_agree_with_mujoco", "SAME", "relative"),
    ("ropes over sheaves", "MuJoCo", "kernel/forces/ropes/test_ropes_over_sheaves", "SAME", "relative"),
    ("flexible pendulum, three modes against twelve segments", "MuJoCo",
     "kernel/multibody/flexible/test_a_flexible_pendulum_agrees_with_mujoco", "ALIKE", "m, of a bow of 0.25 m"),
    ("instant of the fifth event", "SciPy's integrators", "kernel/methods/test_scipy_agrees", "INSTANT", "s"),
    ("peaks of twenty lifts by seven types", "SciPy's DOP853", "validation/test_scipy_lifts_as_other_cranes_do",
     "TENSION", "relative"),
    ("tensions of two cranes over ten seconds", "Drake, Exudyn, MuJoCo", "kernel/simulation/test_the_goliath_reference",
     "TENSION_ERROR", "of 550 kN"),
)  # fmt: skip

NOT_HAD = """Public copies of Ku 2014 (IJCTE 6(3)), Perig 2014 (Shock and Vibration 203709), Park 2016 (Ocean
Engineering 114), Ham 2016 (Automation in Construction 61), Musca 2020 (Symmetry 12(8) 1231), Schlamminger 2022 (Am. J.
Phys. 90, 169) and Stein 2023 (arXiv 2303.02044) are abstracts without figures; of NSRP TIA 2010-620 there is a
foreword, of EN 13001-2 title pages. Incomplete or contradictory: the laboratory crane at 5 A, the double pendulum of
github ffavre13, the string of github HNNUYUXUAN."""


def bound(path: str, name: str) -> float:
    """A constant of a test module, as it stands there."""
    for node in ast.parse((TESTS / f"{path}.py").read_text()).body:
        if isinstance(node, ast.Assign) and [t.id for t in node.targets if isinstance(t, ast.Name)] == [name]:
            return float(ast.literal_eval(node.value))
    raise LookupError(f"tests/{path}.py has no constant {name}")


def other_codes() -> list[str]:
    """Lines of the table of other codes."""
    rows = [
        f"| [{what}](../tests/{path}.py) | {code} | {bound(path, name):g} {of} |"
        for what, code, path, name, of in OTHER_CODES
    ]
    return ["| what | code | agrees within |", "|---|---|---|", *rows]
