"""Unknown references, and bodies, joints and drives that do not fit, each with its error message.

name: (scene, [(old, new), ...], where the caret points, sentence after "error: ")
"""

DRIVES = """mechanism:
  drives:
    one: {joint: J1, type: servo, stiffness: 1 kN m/rad, damping: 1 kN m s/rad, ramp: 1 deg/s2}
    two: {joint: J1, type: prescribed, ramp: 1 deg/s2}"""

REFERENCES = {
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
            "mechanism.drives.one.ramp: '1 m/s2' is not a valid angular acceleration: 'm/s2' is a unit of "
            "acceleration; use deg/s2, rad/s2"
        ),
    ),
    "contradicting orders": (
        "lift",
        [("hoist 3 m/min by 1 m", "hoist 3 m/min by 1 m\n    crane H1: lower 3 m/min by 1 m")],
        "crane H1:",
        "actions[2].crane H1: 'all hooks' and 'crane H1' give crane.H1 two orders at the same time",
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
        "[lift",
        "scene: the list that opens here is not closed by ']', or a comma is missing in it",
    ),
}
