"""`heavylift equations` prints all equations in the paper's notation; the tests evaluate the printed text."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from heavylift.kernel.description import (
    Body,
    Brake,
    Bushing,
    Characteristic,
    InputSignal,
    Joint,
    JointSpring,
    Line,
    Point,
    Reeving,
    Rope,
    Sheave,
    System,
    Torsion,
    UserLaw,
)
from heavylift.kernel.equations import equations
from heavylift.kernel.model import Program
from heavylift.kernel.multibody import build_graph, composites, cut, joint_space_inertia
from heavylift.kernel.multibody.formulations import FORMULATIONS
from heavylift.kernel.multibody.kinematics import kinematics
from small_scenes import EA, LENGTH, G, X, Y, Z, hung, started
from test_the_four_link_arm import GIVEN, PARENT, arm

LABEL = re.compile(r"[A-Za-z]\w*\([^() ]+\)(?:\.\w+)?")
SAME = 1e-12
UNIT6 = tuple(tuple(float(i == j) for j in range(6)) for i in range(6))


def printed(text: str) -> list[tuple[str, str]]:
    """Left and right sides of the equations in coordinates."""
    lines = text[text.index("IN COORDINATES") :].splitlines()
    return [tuple(x.strip().split(" = ", 1)) for x in lines if x.startswith("  ")]


def evaluated(text: str, known: dict[str, float]) -> dict[str, float]:
    """What the printed equations say, in the order in which they stand; a name that is not there yet is zero."""
    values = dict(known)
    functions = {
        "sin": math.sin, "cos": math.cos, "sqrt": math.sqrt, "max": max, "min": min,
        "select": lambda c, a, b: a if c else b,
    }  # fmt: skip
    for left, right in printed(text):
        python = LABEL.sub(lambda m: f"values[{m.group(0)!r}]", right)
        values[left] = eval(python, {"__builtins__": {}}, {**functions, "values": values, "gravity": G, "t": 0.0})
    return values


def test_printed_equations_of_the_four_link_arm_have_the_inertia_matrix_and_forces_of_the_kernel():
    system = arm()
    known = {}
    for i, p in enumerate(PARENT):
        m, l = GIVEN["m"][i], GIVEN["l"][i]
        known |= {f"m(link{i})": m, f"c(link{i}).x": l / 2, f"q(hinge{i}.angle)": GIVEN["q"][i]}
        known |= {f"I(link{i}).yy": m * l * l / 12, f"I(link{i}).zz": m * l * l / 12}
        known |= {f"v(hinge{i}.rate)": GIVEN["qd"][i], f"p(link{i}).x": 0.0 if p < 0 else GIVEN["l"][p]}
    values = evaluated(equations(system), known)
    graph = build_graph(system)
    (tree,) = cut(graph, set())
    K = kinematics(tree, np.array(GIVEN["q"]), np.array(GIVEN["qd"]), G)
    I, F = composites(tree, K, [np.zeros(6)] * 4)
    for (k, l), h in joint_space_inertia(tree, K, I).items():
        assert values[f"H({k},{l})"] == pytest.approx(h, rel=SAME)
    for i, b in enumerate(tree.bodies):
        assert [values.get(f"V({b.name}).{c}", 0.0) for c in ("rx", "ry", "rz", "x", "y", "z")] == pytest.approx(K.V[i])
    total = sum(values[f"f({b.name}).z"] for b in tree.bodies)
    assert total == pytest.approx(F[0][5], rel=SAME)


def test_the_printed_equation_of_a_rope_gives_its_tension_in_the_kernel():
    system = hung(LENGTH + 0.2, v0=0.3, damping=1e5)
    known = {"q(load-guide.travel)": -LENGTH - 0.2, "v(load-guide.speed)": 0.3, "m(load)": 4.5e5}
    known |= {"EA(rope)": EA, "c(rope)": 1e5, "hooked(rope)": 1.0, "taut(rope)": 1.0, "share1(rope)": 1.0}
    known |= {f"{e}1(rope).{c}": 0.0 for e in "ab" for c in "xyz"} | {"s0(rope)": LENGTH}
    values = evaluated(equations(system), known)
    assert values["l(rope)"] == pytest.approx(LENGTH + 0.2, rel=SAME)
    assert values["T(rope)"] == pytest.approx(float(started(system).row().tension[0]), rel=SAME)


def two_of_a_kind() -> System:
    """Two equal carts, which share machine code but not their names, and a law of each kind."""
    bodies = (Body("a", 1.0), Body("b", 2.0))
    joints = tuple(Joint(f"{n}-rail", "prismatic", "world", n, axis=X) for n in "ab")
    return System(
        bodies,
        joints,
        springs=(JointSpring("soft", "a-rail", 3.0),),
        brakes=(Brake("grip", "b-rail", 1.0, 1.0, 1.0),),
        ropes=(Rope("tie", (Line(Point("a"), Point("b", Y)),), 1.0, 1.0),),
        gravity=G,
    )


def test_printed_equations_name_each_body_and_each_force_law():
    text = equations(two_of_a_kind())
    for line in (
        "    F1 = m1 g + f(tie.1)",
        "    M1 = (a(tie.1) - r1) x f(tie.1)",
        "    F2 = m2 g - f(tie.1)",
        "    tau1 = tau(soft)",
        "    tau2 = tau(grip)",
        "  V(a).x = v(a-rail.speed)",
        "  V(b).x = v(b-rail.speed)",
        "  T = EA (l - L0)/L0 + c (l' - L0')   while hooked and taut, else 0",
    ):
        assert f"{line}\n" in text, line
    assert re.search(r"\nsoft +a-rail +3 +0 +0\b", text)


def test_compiling_a_description_does_not_change_its_printed_equations():
    """Programs of one description, and trees of one kind, are made once in a process."""
    system = two_of_a_kind()
    text = equations(system)
    Program(system)
    assert equations(system) == text
    assert "  V(b).x = v(b-rail.speed)\n" in text


def test_the_recursion_printed_for_a_two_link_arm_equals_figure_6_of_the_paper():
    text = equations(arm())
    for line in (
        "    v2 = v1 + S2 q2'             (a)",
        "    a1 = a0 + S1 q1\" + S1' q1'    (b)",
        "    fB3 = I3 a3 + v3 x* I3 v3    (c)",
        "    fc1 = fB1 - fe1 + fc2 + fc3   (d)",
        "    fc3 = fB3 - fe3 + fc4        (d)",
        "    tau4 = S4^T fc4              (e)",
        "    I2 w2' + w2 x I2 w2 = M2 + Mc2 + (p2 - r2) x Fc2",
    ):
        assert f"{line}\n" in text, line


@pytest.mark.parametrize("formulation", FORMULATIONS)
@pytest.mark.parametrize("make", [arm, two_of_a_kind, lambda: hung(60.0)], ids=["arm", "carts", "rope"])
def test_printed_latex_has_the_same_equations_as_the_text_and_balanced_brackets(make, formulation):
    system = make()
    text, latex = equations(system, formulation), equations(system, formulation, latex=True)
    assert latex.startswith("\\documentclass")
    assert latex.endswith("\\end{document}\n")
    check_latex(latex)
    assert latex.count(" &= ") == sum(
        " = " in x for x in text[text.index("EQUATION OF") :].splitlines() if x[:2] == "  "
    )


def check_latex(latex: str) -> None:
    """Braces, brackets of \\left, environments and mathematics close in the order in which they open."""
    bare = re.sub(r"\\[{}$&%#_\\]", "", latex)
    depth = 0
    for c in bare:
        depth += {"{": 1, "}": -1}.get(c, 0)
        assert depth >= 0
    assert depth == 0
    stack: list[str] = []
    for kind, name in re.findall(r"\\(begin|end)\{(\w+\*?)\}", latex):
        if kind == "begin":
            stack.append(name)
        else:
            assert stack.pop() == name
    assert stack == []
    assert "$" not in bare
    for words in re.findall(r"\\text\{((?:[^{}\\]|\\.|\{[^{}]*\})*)\}", latex):  # text has no bare index
        assert not re.search(r"(?<!\\)[_^&#%]", words), words


def test_names_with_special_characters_are_escaped_in_printed_latex():
    joint = Joint("50%_rail", "prismatic", "world", "a_b#1", axis=Z)
    latex = equations(System((Body("a_b#1", 1.0),), (joint,), gravity=G), latex=True)
    check_latex(latex)
    assert r"a\_b\#1" in latex
    assert r"50\%\_rail" in latex


@pytest.mark.parametrize(
    ("force", "formula"),
    [
        (Torsion("t", "world", "load", Z, 1.0), "(k (rest - phi) - d phi') dphi'/dw"),
        (Bushing("b", Point("world"), Point("load"), UNIT6, UNIT6), "-(dx'/dV)^T (K x + D x')"),
        (Characteristic("c", "load-guide", "speed", (0.0, 1.0), (1.0, 0.0)), "s(t) effort(x)"),
        (UserLaw("u", "laws_of_a_user:shaker", "load-guide"), "function(t, state)"),
        (
            Reeving(
                "r",
                Point("world"),
                (Sheave(Point("load"), Y, friction=0.1),),
                Point("world", X),
                1e6,
                InputSignal(130.0),
            ),
            "T_before exp(mu wrap)/efficiency",
        ),
    ],
)
def test_every_kind_of_force_is_printed_with_its_formula(force, formula):
    system = replace(hung(LENGTH), ropes=(), forces=(force,))
    text = equations(system)
    assert formula in text
    assert f"law: {type(force).__name__.lower()}" in text.lower()
    symbol = "tau" if isinstance(force, Characteristic | UserLaw) else "F"  # along a joint, or on bodies
    assert f"\n  {symbol}({force.name}" in text, "in coordinates, too"
