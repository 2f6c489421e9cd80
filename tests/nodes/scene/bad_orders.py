"""Orders that cannot be executed, each with its error message.

name: (scene, [(old, new), ...], where the caret points, sentence after "error: ")
"""

ORDERS = {
    "order against a turn": (
        "turnover",
        [("to 90 deg\n", "to 90 deg\n    B hooks: lower 3 m/min by 1 m\n")],
        "B hooks:",
        "actions[5].B hooks: 'B hooks' must not lower while the block turns: it follows the turn",
    ),
    "condition over an empty set": (
        "turnover",
        [("B hooks: unhook\n", "B hooks: unhook\n  - when: all B slings slack\n    wait: 1 s\n")],
        "when: all",
        "actions[9].when: 'all B slings slack' cannot hold here: none of 4 slings is hooked",
    ),
    "equality on reals": (
        "turnover",
        [("when: all B slings slack", "when: angle = 90 deg")],
        "= 90",
        "actions[7].when: two real numbers are never exactly equal",
    ),
    "unknown target": (
        "lift",
        [("    trolleys: traverse", "    troleys: traverse")],
        "troleys:",
        "actions[3].troleys: there is no 'troleys' to give an order to",
    ),
    "unknown set of slings": (
        "turnover",
        [("when: all B slings", "when: all D slings")],
        "all D",
        "actions[7].when: there is no set of slings 'D'",
    ),
    "verb that does not fit": (
        "lift",
        [("    trolleys: traverse", "    trolleys: travel")],
        "travel",
        "actions[3].trolleys: 'trolleys' cannot travel",
    ),
    "faster than the crane": (
        "lift",
        [("hoist 3 m/min", "hoist 4 m/min")],
        "all hooks:",
        (
            "actions[2].all hooks: hoist 4 m/min is faster than crane can with a load: 3 m/min; "
            "likewise crane.H2, crane.H3"
        ),
    ),
    "turn faster than the winches": (
        "turnover",
        [("turn 0.15 deg/s to 90", "turn 0.3 deg/s to 90")],
        "block: turn",
        (
            "actions[5].block: east.H1 would have to follow the turn at 4.6 m/min, but its maximum is 3 m/min; "
            "likewise east.H2, east.H3, west.H1, west.H2, west.H3"
        ),
    ),
    "turn on the ground": (
        "turnover",
        [
            ("hoist 0.3 m/min until lifted", "hoist 0.3 m/min by 1 mm"),
            ("to 61 m of rope", "by 1 mm"),
            ("to 19.4 m of rope", "by 1 mm"),
            ("cranes: travel 30 m/min ramp 0.03234 m/s2 by 120 m", "wait: 1 s"),
        ],
        "block: turn",
        "actions[5].block: the block stands on its supports and cannot turn: hoist it first",
    ),
    "position without a rope": (
        "lift",
        [("hoist 3 m/min by 1 m", "hoist 3 m/min to 70 m")],
        "hoist 3",
        ("actions[2].all hooks: a winch knows the length of its rope, not a height: write 'to 61 m of rope'"),
    ),
    "verb misspelt": (
        "lift",
        [("hoist 3 m/min", "hoyst 3 m/min")],
        "hoyst 3",
        "actions[2].all hooks: an order begins with a verb, not 'hoyst'",
    ),
    "unknown joint type": (
        "arm",
        [("J1: {type: revolute", "J1: {type: revolut")],
        "revolut",
        "mechanism.joints.J1.type: 'revolut' is not known here",
    ),
}
