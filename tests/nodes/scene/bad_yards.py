"""Overlapping, unreachable or overloaded lifts, each with its error message.

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
        (
            "actions[3]: place on its rails of east would be 476.00 m; 0 to 400 m is allowed (type goliath-900); "
            "likewise west (travel)"
        ),
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
            "actions[3]: place on its girder of crane lower would be 161.00 m; 10 to 140 m is allowed (type "
            "goliath-900); likewise crane upper (sideways)"
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
        "actions[2]: rope length of crane.H3 would be 63.62 m; 64 to 100 m is allowed (type goliath-900) (up)",
    ),
    "rope above its drum": (
        "lift",
        [("at: 40 m}", "at: 40 m, drum: 79 m}"), ("H1, sling: 10 m", "H1, sling: 10 m, rope: 80 m")],
        "drum: 79 m",
        "cranes.crane.drum: rope length of crane.H1 would be 80.00 m; 8 to 79 m is allowed (the scene)",
    ),
    "hook above its upper limit": (
        "lift",
        [("at: 40 m}", "at: 40 m, highest hook: 24 m}")],
        "stage: up",
        (
            "actions[2]: hook height of crane.H1 would be 24.34 m; 24.00 m is allowed (the scene); likewise "
            "crane.H2, crane.H3 (up)"
        ),
    ),
    "hook capacity": (
        "lift",
        [("at: 40 m}", "at: 40 m, hook capacity: 160 t}")],
        "stage: up",
        "actions[2]: hook load of crane.H3 would be 169.8 t, 106 %; 160.0 t is allowed (the scene) (up)",
    ),
    "crane capacity": (
        "lift",
        [("at: 40 m}", "at: 40 m, capacity: 350 t}")],
        "stage: lift",
        "actions[1]: crane load of crane would be 360.0 t, 103 %; 350.0 t is allowed (the scene) (lift off)",
    ),
    "trolley capacity": (
        "lift",
        [("at: 40 m}", "at: 40 m, upper capacity: 180 t}")],
        "stage: lift",
        "actions[1]: trolley load of crane upper would be 190.3 t, 106 %; 180.0 t is allowed (the scene) (lift off)",
    ),
    "tandem capacity": (
        "turnover",
        [("at: 40 m,", "at: 40 m, tandem: 50 %,")],
        "stage: load",
        (
            "actions[1]: tandem load of west would be 510.0 t, 113 %; 450.0 t is allowed (the scene; 50% of its 900 t "
            "as two cranes lift together) (load)"
        ),
    ),
    "sling factor": (
        "lift",
        [("  slack: 50 mm", "  slack: 50 mm\n  sling: {breaking: 3 MN}")],
        "stage: up",
        (
            "actions[2]: sling tension of loader-3.sling-1 would be 734.3 kN, 122 %; 600 kN is allowed (assumed: the "
            "table of EN 13414-1 ends at 60 mm and 42 t a leg; give 'termination' or 'WLL'); likewise loader-3.sling-2 "
            "(up)"
        ),
    ),
    "rope factor": (
        "lift",
        [("at: 40 m}", "at: 40 m, fall breaking: 400 kN}")],
        "stage: lift",
        (
            "actions[1]: rope factor of crane.H3 would be 3.66; at least 5.60 is needed (ISO 4308-1 (withdrawn for ISO "
            "16625), Zp of running ropes, M6; 20 falls, 2 drum ends, sheave efficiency 0.98: lead part 1.093 of the "
            "mean) (lift off)"
        ),
    ),
    "centre of mass outside the lugs": (
        "lift",
        [("  supports:", "  com: [5 m, 0 m, 0 m]\n  supports:")],
        "stage: lift",
        (
            "actions[1]: the block tips by 19 degrees as it is lifted, and loader-1.sling-1 goes slack: its centre of "
            "mass is not between the lugs that carry it"
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
        "actions[8]: no taut sling is left: the block would fall (unhook B)",
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
