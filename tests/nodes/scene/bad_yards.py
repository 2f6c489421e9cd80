"""Yards that cannot stand or lift: what overlaps, does not reach, or carries more than it may.

name: (scene, [(old, new), ...], where the caret points, sentence after "error: ")
"""

YARDS = {
    "portals overlap on the way": (
        "turnover",
        [("cranes: travel 30 m/min ramp 0.03234 m/s2 by 120 m", "west: travel 30 m/min by 3 m")],
        "stage: travel",
        ("actions[3]: east and west overlap: 33 m from middle to middle, but they need 34 m (travel)"),
    ),
    "past the rails": (
        "turnover",
        [("by 120 m", "by 400 m")],
        "stage: travel",
        ("actions[3]: east at x = 476 m is past the end of its rails, 0 to 400 m; likewise west (travel)"),
    ),
    "a crane off its rails, whose hooks are then elsewhere, too": (
        "lift",
        [("goliath-900, at: 40 m", "goliath-900, at: 4000 m")],
        "4000 m",
        "cranes.crane.at: crane begins at 4000, past the end of its range, 0 to 400",
    ),
    "block under no hook": (
        "lift",
        [("at: [40 m, 75 m, 6 m]", "at: [140 m, 75 m, 6 m]")],
        "block:",
        ("block: the block at x = 140 m, y = 75 m lies under no hook: hooks hang at 34 / 69 m, 46 / 69 m, 40 / 81 m"),
    ),
    "block above its stools": (
        "lift",
        [("at: [40 m, 75 m, 6 m]", "at: [40 m, 75 m, 7 m]")],
        "block:",
        "block: the block is 1 m above its supports: put its middle at z = 6 m",
    ),
    "trolley past the girder": (
        "lift",
        [("by 2 m", "by 80 m")],
        "stage: sideways",
        (
            "actions[3]: the lower trolley of crane at y = 161 m is past the end of its girder, 10 to"
            " 140 m; likewise crane upper (sideways)"
        ),
    ),
    "trolley through its neighbour": (
        "lift",
        [
            ("at: 40 m}", "at: 40 m, lower exit: 100 m}"),
            ("    trolleys: traverse 20 m/min by 2 m", "    lower trolleys: traverse 20 m/min by -15 m"),
        ],
        "stage: sideways",
        (
            "actions[3]: the lower trolley of crane and the upper trolley of crane overlap: 3 m from middle"
            " to middle, but they need 10 m (sideways)"
        ),
    ),
    "sling too short": (
        "lift",
        [("{hook: crane H1, sling", "{hook: crane H1, rope: 75 m, sling")],
        "sling: 10",
        (
            "rig.loaders.loader-1.sling: loader-1.sling-1 is 3682 mm too short for the lug P1: lower "
            "the hook or take a longer sling than 10 m"
        ),
    ),
    "sling from too far": (
        "lift",
        [("at: 40 m}", "at: 40 m, lower trolley: 88 m}")],
        "sling: 10",
        (
            "rig.loaders.loader-3.sling: the hook stands 7.0 m beside the lug R1, too far for the 10 "
            "m of loader-3.sling-1 (2166 mm are missing): move crane or trolley first; its lugs are "
            "R1 (-2, 6, 4.3) m, R2 (2, 6, 4.3) m"
        ),
    ),
    "hooked from too far": (
        "turnover",
        [("traverse 20 m/min ramp 0.0278 m/s2 by -11.2 m", "traverse 20 m/min by -3 m")],
        "B hooks:",
        (
            "actions[13].B hooks: the hook stands 8.2 m beside the lug C1, too far for the 30 m of "
            "loader-3.sling-1 (982 mm are missing): move crane or trolley first; likewise loader-6"
        ),
    ),
    "lug inside the block": (
        "lift",
        [("P1: [-8 m, -6 m, 4.3 m]", "P1: [-8 m, -6 m, 3.3 m]")],
        "P1: [-8",
        "block.lugs.P1: the lug P1 is inside the block, 0.7 m below its face at w = 4 m",
    ),
    "rope below its minimum": (
        "lift",
        [("at: 40 m}", "at: 40 m, shortest rope: 64 m}")],
        "stage: up",
        "actions[2]: the rope crane.H3 would be wound to 63.6173 m, its minimum is 64 m (up)",
    ),
    "rope above its drum": (
        "lift",
        [("at: 40 m}", "at: 40 m, drum: 79 m}"), ("H1, sling: 10 m", "H1, sling: 10 m, rope: 80 m")],
        "drum: 79 m",
        "cranes.crane.drum: the rope crane.H1 would be 80 m long, its drum holds 79 m",
    ),
    "hook above its upper limit": (
        "lift",
        [("at: 40 m}", "at: 40 m, highest hook: 24 m}")],
        "stage: up",
        (
            "actions[2]: the hook crane.H1 would be at z = 24.34 m, its upper limit is 24 m; likewise "
            "crane.H2, crane.H3 (up)"
        ),
    ),
    "hook capacity": (
        "lift",
        [("at: 40 m}", "at: 40 m, hook capacity: 160 t}")],
        "stage: up",
        "actions[2]: the hook crane.H3 would carry 169.8 t of 160 t (up)",
    ),
    "crane capacity": (
        "lift",
        [("at: 40 m}", "at: 40 m, capacity: 350 t}")],
        "stage: lift",
        "actions[1]: crane would carry 360.0 t of 350 t (lift off)",
    ),
    "trolley capacity": (
        "lift",
        [("at: 40 m}", "at: 40 m, upper capacity: 180 t}")],
        "stage: lift",
        "actions[1]: the upper trolley of crane would carry 190.3 t of 180 t (lift off)",
    ),
    "tandem capacity": (
        "turnover",
        [("at: 40 m,", "at: 40 m, tandem: 50 %,")],
        "stage: load",
        ("actions[1]: west would carry 510.0 t of 450 t, 50% of its 900 t as two cranes lift together (load)"),
    ),
    "sling factor": (
        "lift",
        [("  slack: 50 mm", "  slack: 50 mm\n  sling: {breaking: 3 MN}")],
        "stage: up",
        (
            "actions[2]: the tension of the sling loader-3.sling-1 would be 734 kN, 122 % of its limit: 4.09 "
            "times below its breaking force, 5 are needed (assumed: the table of EN 13414-1 ends at 60 mm and 42 t a "
            "leg); likewise loader-3.sling-2 (up)"
        ),
    ),
    "rope factor": (
        "lift",
        [("at: 40 m}", "at: 40 m, fall breaking: 400 kN}")],
        "stage: lift",
        (
            "actions[1]: the rope crane.H3 has too little safety: its most loaded part carries 109.4 kN, 3.66 "
            "times below its breaking force, 5.6 are needed (20 falls, 2 drum ends, sheave efficiency "
            "0.98: lead part 1.093 of the mean) (lift off)"
        ),
    ),
    "centre of mass outside the lugs": (
        "lift",
        [("  supports:", "  com: [5 m, 0 m, 0 m]\n  supports:")],
        "stage: lift",
        (
            "actions[1]: the block tips by 19 degrees as it is lifted, and loader-1.sling-1 goes slack: its centre of "
            "mass is not between the lugs that carry"
        ),
    ),
    "centre of mass outside the stools": (
        "lift",
        [("  supports:", "  com: [9 m, 0 m, 0 m]\n  supports:")],
        "[-8 m",
        ("block.supports.at[0]: the centre of mass at u = 9 m, v = 0 m is not above the supports: the block would tip"),
    ),
    "block would fall": (
        "turnover",
        [("    B hooks: unhook", "    all hooks: unhook")],
        "stage: unhook",
        "actions[8]: no sling is taut: the block would fall (unhook B)",
    ),
    "travel while grounded": (
        "lift",
        [("    all hooks: hoist 0.3 m/min until lifted", "    crane: travel 3 m/min by 1 m")],
        "crane: travel",
        (
            "actions[1].crane: crane would travel while the block is on its supports and loader-1.sling-1 taut:"
            " slacken or unhook the slings first"
        ),
    ),
    "negative mass": (
        "lift",
        [("mass: 300 t", "mass: -300 t")],
        "-300 t",
        "block.mass: a mass must be greater than zero here, not -300 t",
    ),
}
