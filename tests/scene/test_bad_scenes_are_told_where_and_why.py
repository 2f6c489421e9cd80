"""Every bad scene is refused with its exact sentence, and the caret stands where the user has to change something.

Each case edits a bundled scene in one place; `points_at` is the text at the line and column of the message.
"""

import re

import pytest
from heavylift.coordinator.transport.keys import OBSERVER, check_names
from heavylift.kernel.errors import ProtocolError, SceneError
from heavylift.nodes.models import COMMANDER, KERNEL
from heavylift.nodes.scene import bundled, parse
from heavylift.nodes.scene.schema import RESERVED

TEXTS = {name: path.read_text(encoding="utf-8") for name, path in bundled().items()}
HEAD = re.compile(r"(?P<file>[^:]+):(?P<line>\d+):(?P<column>\d+): error: (?P<told>.*)")

DRIVES = """mechanism:
  drives:
    one: {joint: J1, type: servo, stiffness: 1 kN m/rad, damping: 1 kN m s/rad, ramp: 1 deg/s2}
    two: {joint: J1, type: prescribed, ramp: 1 deg/s2}"""

TOLD = {"1e9": "1000000000", ".inf": "inf", ".nan": "nan"}  # as a number that stands without its unit is told

# name: (scene, [(old, new), ...], points at, sentence after "error: ")
BAD = {
    "unknown key": (
        "lift",
        [("type: goliath-900, at: 40 m", "type: goliath-900, att: 40 m, at: 40 m")],
        "att: 40",
        "cranes.crane.att: unknown key 'att'",
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
        "block.mass: '300 kN' is no mass: 'kN' is a unit of force; use t, kg",
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
        "east: {type:",
        (
            "cranes.east: the portals of west and east overlap: 30 m from centre to centre, but 34 m "
            "from buffer to buffer"
        ),
    ),
    "portals overlap on the way": (
        "turnover",
        [("cranes: travel 30 m/min ramp 0.03234 m/s2 by 120 m", "west: travel 30 m/min by 3 m")],
        "stage: travel",
        (
            "actions[3]: the portals of west and east overlap: 33 m from centre to centre, but 34 m "
            "from buffer to buffer (travel)"
        ),
    ),
    "past the rails": (
        "turnover",
        [("by 120 m", "by 400 m")],
        "stage: travel",
        ("actions[3]: west at x = 440 m is past the end of its rails, 0 to 400 m; likewise east (travel)"),
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
        "block: the block is 1 m above its stools: put its middle at z = 6 m",
    ),
    "trolley past the girder": (
        "lift",
        [("by 2 m", "by 80 m")],
        "stage: sideways",
        (
            "actions[3]: the upper trolley of crane at y = 149 m is past the end of its girder, 10 to"
            " 140 m; likewise crane lower (sideways)"
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
            "actions[3]: the trolleys of crane run on one level and would go through each other: they"
            " need 10 m from middle to middle, not 3 m (sideways)"
        ),
    ),
    "sling too short": (
        "lift",
        [("{hook: crane H1, sling", "{hook: crane H1, rope: 75 m, sling")],
        "sling: 10",
        (
            "rig.loaders.loader-1.sling: loader-1.sling-1 is 3700 mm too short for the lug P1: lower "
            "the hook or take a longer sling than 10 m"
        ),
    ),
    "sling from too far": (
        "lift",
        [("at: 40 m}", "at: 40 m, lower trolley: 88 m}")],
        "sling: 10",
        (
            "rig.loaders.loader-3.sling: the hook stands 7.0 m beside the lug R1, too far for the 10 "
            "m of loader-3.sling-1 (2178 mm are missing): move crane or trolley first"
        ),
    ),
    "hooked from too far": (
        "turnover",
        [("traverse 20 m/min ramp 0.0278 m/s2 by -11.2 m", "traverse 20 m/min by -3 m")],
        "B hooks:",
        (
            "actions[13].B hooks: the hook stands 8.2 m beside the lug C1, too far for the 30 m of "
            "loader-3.sling-1 (908 mm are missing): move crane or trolley first; likewise loader-6"
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
        "actions[2]: the rope crane.H3 would be wound to 63.7 m, its minimum is 64 m (up)",
    ),
    "rope above its drum": (
        "lift",
        [("at: 40 m}", "at: 40 m, drum: 79 m}"), ("H1, sling: 10 m", "H1, sling: 10 m, rope: 80 m")],
        "hook: crane",
        "rig.loaders.loader-1.hook: the rope crane.H1 would be 80 m long, its drum holds 79 m",
    ),
    "hook above its upper limit": (
        "lift",
        [("at: 40 m}", "at: 40 m, highest hook: 24 m}")],
        "stage: up",
        (
            "actions[2]: the hook crane.H1 would be at z = 24.3 m, its upper limit is 24 m; likewise "
            "crane.H2, crane.H3 (up)"
        ),
    ),
    "hook capacity": (
        "lift",
        [("at: 40 m}", "at: 40 m, hook capacity: 160 t}")],
        "stage: lift",
        "actions[1]: the hook crane.H3 would carry 170.0 t of 160 t (lift off)",
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
        "actions[1]: the upper trolley of crane would carry 190.0 t of 180 t (lift off)",
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
        "stage: lift",
        (
            "actions[1]: each sling of loader-3 has too little safety: 735 kN are 4.08 times below "
            "its breaking force, 5 are needed (lift off)"
        ),
    ),
    "rope factor": (
        "lift",
        [("at: 40 m}", "at: 40 m, fall breaking: 400 kN}")],
        "stage: lift",
        (
            "actions[1]: the rope crane.H3 has too little safety: 1912 kN are 4.18 times below its "
            "breaking force, 5.6 are needed (lift off)"
        ),
    ),
    "centre of mass outside the lugs": (
        "lift",
        [("  supports:", "  com: [5 m, 0 m, 0 m]\n  supports:")],
        "stage: lift",
        (
            "actions[1]: the centre of mass is 1.19 m outside the polygon of the lugs that carry: the"
            " block would tip (lift off)"
        ),
    ),
    "centre of mass outside the stools": (
        "lift",
        [("  supports:", "  com: [9 m, 0 m, 0 m]\n  supports:")],
        "[-8 m",
        ("block.supports.at[0]: the centre of mass at u = 9 m, v = 0 m is not above the stools: the block would tip"),
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
            "actions[1].crane: crane would travel while the block is on its stools and loader-1 taut:"
            " slacken or unhook the slings first"
        ),
    ),
    "negative mass": (
        "lift",
        [("mass: 300 t", "mass: -300 t")],
        "-300 t",
        "block.mass: a mass must be greater than zero here, not -300 t",
    ),
    "zero mass": (
        "arm",
        [("mass: 400 kg", "mass: 0 kg")],
        "0 kg",
        "mechanism.bodies.link-1.mass: a mass must be greater than zero here, not 0 kg",
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
    "unknown hook": (
        "lift",
        [("hook: crane H2", "hook: crane H4")],
        "crane H4",
        "rig.loaders.loader-2.hook: there is no hook 'crane H4'",
    ),
    "hook taken": (
        "lift",
        [("hook: crane H2", "hook: crane H1")],
        "crane H1",
        "rig.loaders.loader-2.hook: the hook crane H1 already carries loader-1",
    ),
    "lug taken": (
        "lift",
        [("lugs: [Q1, Q2]", "lugs: [P1, Q2]")],
        "P1, Q2",
        "rig.loaders.loader-2.lugs[0]: the lug P1 already carries a sling of loader-1",
    ),
    "unknown lug": (
        "turnover",
        [("hook [C1, C2, C3, C4]", "hook [C1, C2, C3, C5]")],
        "hook [C1",
        "actions[13].B hooks: the block has no lug 'C5'",
    ),
    "two drives on one joint": (
        "arm",
        [
            (
                "mechanism:",
                DRIVES,
            )
        ],
        "J1, type:",
        "mechanism.drives.two.joint: the joint 'J1' has two drives, 'one' and 'two': keep one",
    ),
    "units of another joint": (
        "arm",
        [
            (
                "mechanism:",
                DRIVES.replace("1 deg/s2", "1 m/s2", 1).replace("two: {joint: J1", "two: {joint: J2"),
            )
        ],
        "1 m/s2",
        (
            "mechanism.drives.one.ramp: '1 m/s2' is no angular acceleration: 'm/s2' is a unit of "
            "acceleration; use deg/s2, rad/s2"
        ),
    ),
    "contradicting orders": (
        "lift",
        [("hoist 3 m/min by 1 m", "hoist 3 m/min by 1 m\n    crane H1: lower 3 m/min by 1 m")],
        "crane H1:",
        "actions[2].crane H1: 'all hooks' and 'crane H1' give crane.H1 two orders at the same time",
    ),
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
        "actions[9].when: 'all B slings slack' says nothing here: none of 4 slings is hooked then",
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
        [("    trolleys: traverse", "    crane: traverse")],
        "traverse",
        "actions[3].crane: 'crane' cannot traverse",
    ),
    "faster than the crane": (
        "lift",
        [("hoist 3 m/min", "hoist 4 m/min")],
        "all hooks:",
        ("actions[2].all hooks: hoist 4 m/min is faster than crane can: 3 m/min; likewise crane.H2, crane.H3"),
    ),
    "turn faster than the winches": (
        "turnover",
        [("turn 0.15 deg/s to 90", "turn 0.3 deg/s to 90")],
        "block: turn",
        (
            "actions[5].block: west.H1 would have to follow the turn at 4.6 m/min, it can 3 m/min; "
            "likewise west.H2, west.H3, east.H1, east.H2, east.H3"
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
        "actions[5].block: the block stands on its stools and cannot turn: hoist it first",
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
    "unknown parent": (
        "arm",
        [("J4: {type: revolute, parent: link-3", "J4: {type: revolute, parent: link-33")],
        "link-33",
        "mechanism.joints.J4.parent: there is no body 'link-33'",
    ),
    "a body that nothing carries": (
        "arm",
        [("    J4: {", "    # J4: {")],
        "link-4: {mass:",
        "mechanism.bodies.link-4: no joint carries the body 'link-4'",
    ),
    "a free point": (
        "pendulum",
        [("pivot: {type: revolute, child: load, axis: [0, 1, 0], start: 10 deg}", "pivot: {type: free, child: load}")],
        "load:",
        "mechanism.bodies.load: the body 'load' moves freely and nothing resists its turning: "
        "give it moments with 'inertia'",
    ),
    "no YAML": (
        "lift",
        [("name: lift", "name: [lift")],
        ": 60",
        "scene: this is not YAML: expected ',' or ']', but got ':'",
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


def refused(text: str, *settings: str) -> str:
    with pytest.raises(SceneError) as refusal:
        parse(text, "scene.yaml", settings)
    return str(refusal.value)


@pytest.mark.parametrize("name", BAD)
def test_a_bad_scene(name: str) -> None:
    scene, edits, points_at, sentence = BAD[name]
    text = TEXTS[scene]
    for old, new in edits:
        assert old in text
        text = text.replace(old, new, 1)
    told = refused(text)
    heads = [match for match in map(HEAD.fullmatch, told.splitlines()) if match]
    assert [match["told"] for match in heads] == [sentence]
    line, column = int(heads[0]["line"]), int(heads[0]["column"])
    assert text.splitlines()[line - 1][column - 1 :].startswith(points_at)
    shown, caret = told.splitlines()[1:3]
    assert shown[caret.index("^") :].startswith(points_at)


def test_all_errors_at_once_with_source_line_caret_and_hint() -> None:
    text = """\
heavylift: 1
name: two cranes
gravty: 9.81 m/s2
cranes:
  west: {type: goliath-90, at: 40}
  west: {type: goliath-900, at: 3 m}
actions:
  - all hooks: hoist 3 m/min bye 2 m
    when: angle = 90 deg
"""
    assert (
        refused(text)
        == """\
scene.yaml:2:7: error: name: a name has letters, digits, '-' and '_' only, but 'two cranes' has ' '
    2 | name: two cranes
      |       ^
scene.yaml:3:1: error: gravty: unknown key 'gravty'
    3 | gravty: 9.81 m/s2
      | ^ did you mean 'gravity'?
scene.yaml:5:16: error: cranes.west.type: 'goliath-90' is not known here
    5 |   west: {type: goliath-90, at: 40}
      |                ^ did you mean 'goliath-900'?
scene.yaml:5:32: error: cranes.west.at: missing unit: write '40 m' or '40000 mm'
    5 |   west: {type: goliath-90, at: 40}
      |                                ^
scene.yaml:6:3: error: cranes.west: the name 'west' is given twice (first in line 5)
    6 |   west: {type: goliath-900, at: 3 m}
      |   ^
scene.yaml:8:30: error: actions[0].all hooks: after the speed 'by' or 'to' or 'until' must follow, not 'bye'
    8 |   - all hooks: hoist 3 m/min bye 2 m
      |                              ^ did you mean 'by'?
scene.yaml:9:17: error: actions[0].when: two real numbers are never exactly equal
    9 |     when: angle = 90 deg
      |                 ^ write 'angle >= 90 deg' or 'angle <= 90 deg'
7 errors in scene.yaml"""
    )


def test_a_setting_is_told_like_a_line_of_the_scene() -> None:
    assert (
        refused(TEXTS["lift"], "cranes.crane.at=41")
        == """\
--set:1:17: error: cranes.crane.at: missing unit: write '41 m' or '41000 mm'
    1 | cranes.crane.at=41
      |                 ^
1 error in scene.yaml"""
    )
    assert "did you mean 'at'?" in refused(TEXTS["lift"], "cranes.crane.att=41 m")
    assert "the scene has no place 'actions.9'" in refused(TEXTS["lift"], "actions.9=wait 3 s")
    assert "write a setting as key=value" in refused(TEXTS["lift"], "seed")


@pytest.mark.parametrize("text", ["", "- a", "just words", "heavylift: [1", "a: &x [*x]", "? [a]\n: 1", "{}"])
def test_whatever_stands_in_the_file_ends_in_sentences(text: str) -> None:
    assert HEAD.fullmatch(refused(text).splitlines()[0])


def test_whatever_a_run_names_itself_is_reserved() -> None:
    assert {COMMANDER, KERNEL, OBSERVER, "event", "coordinator"} <= set(RESERVED)
    for word in ("event", OBSERVER):
        with pytest.raises(ProtocolError):
            check_names([word], "node")


def test_rope_lines_to_unknown_bodies_are_told_with_all_else() -> None:
    told = refused("""\
heavylift: 1
name: hanging
end: 1 s
mechanism:
  bodies:
    load: {mass: 1 t}
  joints:
    slide: {type: prismatic, child: load, axis: [0, 0, 1]}
  ropes:
    hoist:
      lines: [{start: {body: wold}, end: {body: load}}, {start: {body: world}, end: {body: lod}}]
      EA: 1 MN
      length: 9 m
""")
    assert [line for line in told.splitlines() if HEAD.fullmatch(line)] == [
        "scene.yaml:11:30: error: mechanism.ropes.hoist.lines[0].start.body: there is no body 'wold'",
        "scene.yaml:11:92: error: mechanism.ropes.hoist.lines[1].end.body: there is no body 'lod'",
    ]
