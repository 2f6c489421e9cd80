"""Invalid keys, units, numbers and names of a scene file, each with its error message.

name: (scene, [(old, new), ...], where the caret points, sentence after "error: ")
"""

from heavylift.nodes.scene.keys import RESERVED

TOLD = {"1e9": "1000000000", ".inf": "inf", ".nan": "nan"}  # as a number that stands without its unit is reported

WORDS = {
    "unknown key": (
        "lift",
        [("type: goliath-900, at: 40 m", "type: goliath-900, att: 40 m, at: 40 m")],
        "att: 40",
        "cranes.crane.att: the type goliath-900 has no parameter 'att'",
    ),
    "missing key": (
        "lift",
        [("  mass: 300 t\n", "")],
        "block:",
        "block.mass: the key 'mass' is missing",
    ),
    "missing unit": (
        "turnover",
        [("mass: 900 t", "mass: 900")],
        "900",
        "block.mass: missing unit: write '900 t' or '900000 kg'",
    ),
    "another unit": (
        "lift",
        [("mass: 300 t", "mass: 300 kN")],
        "300 kN",
        "block.mass: '300 kN' is not a valid mass: 'kN' is a unit of force; use t, kg",
    ),
    "a dash for a minus": (
        "lift",
        [("mass: 300 t", "mass: \N{EN DASH}300 t")],
        "\N{EN DASH}300 t",
        "block.mass: '\N{EN DASH}300 t' is not a valid mass: a minus sign is the '-' of the keyboard: write '-300 t'",
    ),
    "a time of the clock": (
        "lift",
        [("wait: 20 s", "wait: 1:00")],
        "1:00",
        "actions[4].wait: '1:00' is not a valid time: write '60 s' or '60 min', as it is meant",
    ),
    "a decimal comma in a phrase": (
        "lift",
        [("hoist 3 m/min by 1 m", "hoist 3 m/min by 1,5 m or until all slings slack")],
        "1,5 m",
        "actions[2].all hooks: '1,5 m' is not a valid length: a decimal has a point, no comma: write '1.5 m'",
    ),
    "a key of an action, nearly": (
        "lift",
        [("- stage: up", "- stag: up")],
        "stag: up",
        "actions[2].stag: there is no 'stag' to give an order to",
    ),
    "indented by a tab": (
        "lift",
        [("  mass: 300 t", "\tmass: 300 t")],
        "\tmass",
        "scene: indent with spaces, not tabs",
    ),
    "position of what has none": (
        "lift",
        [("until lifted", "until position of block >= 3 m")],
        "position of block",
        "actions[1].all hooks: there is no 'block' with position",
    ),
    "missing unit in a phrase": (
        "lift",
        [("hoist 3 m/min", "hoist 3")],
        "3 by",
        "actions[2].all hooks: missing unit: write '3 m/min' or '0.05 m/s'",
    ),
    "portals overlap": (
        "turnover",
        [("at: 76 m", "at: 70 m")],
        "west: {type:",
        ("cranes.west: east and west overlap: 30 m from middle to middle, but they need 34 m"),
    ),
    "negative mass": (
        "arm",
        [("mass: 400 kg", "mass: -400 kg")],
        "-400 kg",
        "mechanism.bodies.link-1.mass: a mass must be zero or more here, not -400 kg",
    ),
    "zero speed": (
        "lift",
        [("hoist 3 m/min", "hoist 0 m/min")],
        "0 m/min",
        "actions[2].all hooks: a speed must be greater than zero: the verb says the direction",
    ),
    "negative speed": (
        "lift",
        [("traverse 20 m/min", "traverse -20 m/min")],
        "-20 m/min",
        "actions[3].trolleys: a speed must be greater than zero: the verb says the direction",
    ),
    "negative ramp": (
        "lift",
        [("at: 40 m}", "at: 40 m, ramp: -1 m/s2}")],
        "-1 m/s2",
        "cranes.crane.ramp: an acceleration must be greater than zero here, not -1 m/s2",
    ),
    "zero ramp": (
        "lift",
        [("hoist 3 m/min by", "hoist 3 m/min ramp 0 m/s2 by")],
        "0 m/s2",
        "actions[2].all hooks: an acceleration must be greater than zero: the verb says the direction",
    ),
    "duplicate names": (
        "turnover",
        [("  east: {", "  west: {")],
        "west: {type:",
        "cranes.west: the name 'west' is given twice (first in line 41)",
    ),
    "one name for two machines": (
        "lift",
        [("loader-2:", "crane:")],
        "crane: {hook:",
        "rig.loaders.crane: the name 'crane' is given twice: a crane has it, too",
    ),
    **{
        f"crane named {word}": (
            "lift",
            [("  crane: {", f"  {word}: {{")],
            f"{word}: {{type",
            f"cranes.{word}: the name '{word}' is reserved: choose another",
        )
        for word in RESERVED
    },
    **{
        f"mechanism named {word}": (
            "pendulum",
            [("name: pendulum\n  bodies", f"name: {word}\n  bodies")],
            word,
            f"mechanism.name: the name '{word}' is reserved: choose another",
        )
        for word in RESERVED
    },
    "loader named observer": (
        "lift",
        [("loader-2:", "observer:")],
        "observer: {hook:",
        "rig.loaders.observer: the name 'observer' is reserved: choose another",
    ),
    "group named block": (
        "lift",
        [("rig:", "rig:\n  groups: {block: [crane H1]}")],
        "block: [crane",
        "rig.groups.block: the name 'block' is reserved: choose another",
    ),
    **{
        f"{key} {value}": (
            "pendulum",
            [("end: 320 s", "seed: 1"), (f"{key}: {old}" if old else "heavylift: 1", f"{extra}{key}: {value}")],
            value,
            f"{key}: {told} is out of range: choose {allowed}",
        )
        for key, old, extra, allowed, values in (
            (
                "samples",
                "20 Hz",
                "end: 1 s\n",
                "0.001 Hz to 10 kHz",
                ("1e-12 Hz", "0", "-1 Hz", "nan", ".inf", "1e9 Hz"),
            ),
            ("accuracy", "1e-6 %", "end: 1 s\n", "1e-10 % to 10 %", ("1e9", "0 %", "-1 %", ".nan", "inf", "1e-11 %")),
            ("end", "", "heavylift: 1\n", "0.001 ms to 100 days", ("0 s", "-1 s", ".nan", "inf", "1e9 s", "101 days")),
        )
        for value, told in ((v, TOLD.get(v, v)) for v in values)
    },
    "timeout out of range": (
        "lift",
        [("  - stage: up", "  - timeout: 1e99 h\n    stage: up")],
        "1e99 h",
        "actions[2].timeout: 1e99 h is out of range: choose 0.001 ms to 100 days",
    ),
    "wait out of range": (
        "turnover",
        [("wait: 15 min", "wait: 15e9 min")],
        "15e9 min",
        "actions[12].wait: 15e9 min is out of range: choose 0.001 ms to 100 days",
    ),
    "wait of no number": (
        "turnover",
        [("wait: 15 min", "wait: .nan")],
        ".nan",
        "actions[12].wait: nan is out of range: choose 0.001 ms to 100 days",
    ),
    "wait without a unit": (
        "turnover",
        [("  - stage: rigging", "  - wait 60\n  - stage: rigging")],
        "60",
        "actions[12]: missing unit: write '60 s' or '1 min'",
    ),
    "rope to an unknown body": (
        "pendulum",
        [
            (
                "  joints:",
                "  ropes:\n    rope: {start: {body: world}, end: {body: lood}, EA: 1 MN, length: 9 m}\n  joints:",
            )
        ],
        "lood}",
        "mechanism.ropes.rope.end.body: there is no body 'lood'",
    ),
    "another version": (
        "lift",
        [("heavylift: 1", "heavylift: 2")],
        "2",
        "heavylift: this heavylift reads scenes of version 1, not 2",
    ),
    "no end": (
        "pendulum",
        [("end: 320 s", "seed: 1")],
        "heavylift:",
        "scene: the scene never ends: give it 'actions' or an 'end', such as 'end: 60 s'",
    ),
}
