"""What the page says besides its rows: tables and their introductions, other codes, sources that were looked for."""

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
    "Design factors": "Factors of rules are made to be on the safe side: ours shall not exceed them for a slow lift.",
    "Worked examples of rules and tools": (
        "The printed result of the first could not be read: theirs is the printed formula with the printed inputs."
    ),
    "Published problems": (
        "The problems are published; unless the source is said to publish the figure itself, theirs is the project's "
        "own solution with 113 bits, confirmed by a second method, since published figures carry too few digits."
    ),
    "Published measurements": (
        "*Within* is here the uncertainty of the measurement as far as the source tells it: reading errors, scatter, "
        "stated accuracies. Inputs are measured, too (motion of the trolley, lengths, masses); nothing is fitted to "
        "what is compared."
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
    ("tensions of two cranes over ten seconds", "Drake, Exudyn, MuJoCo", "kernel/simulation/test_the_goliath_reference",
     "TENSION_ERROR", "of 550 kN"),
)  # fmt: skip

NOT_HAD = (  # source, what of it could be read, and why it is not in the tables
    ("Ku, Ha, Roh 2014, IJCTE 6(3): lifts against shipyard measurements", "abstract, two copies at scribd.com",
     "says that results were compared with data of a shipyard; no figure could be read"),
    ("NSRP TIA 2010-620, final report 2012: instrumented block lifts", "foreword, at scribd.com",
     "the measured figures stand in six block reports, none of which could be found"),
    ("Perig et al. 2014, Shock and Vibration 203709: slewing pendulum", "abstract, hindawi.com and thefreelibrary.com",
     "“good agreement” with averaged experiments, no figure"),
    ("Park, Ham, Lee 2016, Ocean Engineering 114", "abstract, at coek.info", "observations of operations, no figure"),
    ("Ham, Roh, Lee 2016, Automation in Construction 61: equalisers", "abstract, scribd.com and sydlab.snu.ac.kr",
     "simulations only, as far as the abstract tells"),
    ("Musca, Debeleac, Vlase 2020, Symmetry 12(8) 1231: wire rope", "abstract and captions, copies of mdpi.com",
     "masses (8 and 19 kg), but neither frequency nor damping"),
    ("Custer, ES255: transverse vibration of tensioned rope", "summary, at studylib.net",
     "60 % of readings within 6 % of the string formula, none off by more than 13 %; the readings themselves not"),
    ("Schlamminger et al. 2022, Am. J. Phys. 90, 169: crane operator's trick", "abstract, pubs.aip.org", "no figure"),
    ("Stein, Parcic, Singh 2023, arXiv 2303.02044: pendulum of changing length", "abstract, ar5iv.org", "no figure"),
    ("EN 13001-2: hoisting classes", "title pages, at scribd.com and iteh.ai",
     "the factor in the table is quoted from the project's closed forms, which name the standard"),
    ("the laboratory crane's runs at 5 A and the logs of its angle sensor", "all",
     "one run begins in mid-swing, one track jumps at 3.1 s; the sensor's filter is not described"),
    ("double pendulum on video, 2026 (github ffavre13/Physics_Double-Pendulum, rdtjulien/PendulePhysic)",
     "all, read twice by different students", "masses are not given, so that nothing could be predicted"),
    ("string in resonance (github HNNUYUXUAN/general-physics-lab)", "readings",
     "80 g and 100 g gave the same wavelength within 1 %, so the readings contradict each other"),
)  # fmt: skip


def bound(path: str, name: str) -> float:
    """A constant of a test module, as it stands there."""
    for node in ast.parse((TESTS / f"{path}.py").read_text()).body:
        if isinstance(node, ast.Assign) and [t.id for t in node.targets if isinstance(t, ast.Name)] == [name]:
            return float(ast.literal_eval(node.value))
    raise LookupError(f"tests/{path}.py has no constant {name}")


def other_codes() -> list[str]:
    """Lines of the table of other codes."""
    rows = [
        f"| {what} | {code} | {bound(path, name):g} {of} | [{path.rpartition('/')[2]}](../tests/{path}.py) |"
        for what, code, path, name, of in OTHER_CODES
    ]
    return ["| what | code | agrees within | shown in |", "|---|---|---|---|", *rows]
