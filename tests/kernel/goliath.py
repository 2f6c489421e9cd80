"""The 24-degree-of-freedom two-crane scene of the reference trajectory: loaders pinned to the block, six ropes."""

from heavylift.kernel.description import Body, Drive, Joint, JointSpring, Line, Point, Rope, System

G = 9.81
EA, ROPE_DAMPING, HINGE_DAMPING = 6.0e8, 3.3e4, 5.0e3
KP, KV = 1.0e7, 4.0e6
HOOK_Y = (-5.0, 0.0, 5.0)


def box(mass, x, y, z):
    """Inertia of a homogeneous box."""
    i = mass / 12.0
    return ((i * (y * y + z * z), 0.0, 0.0), (0.0, i * (x * x + z * z), 0.0), (0.0, 0.0, i * (x * x + y * y)))


def scene(hooks: tuple[float, ...] = HOOK_Y) -> System:
    bodies, joints, springs, drives, ropes = [], [], [], [], []

    def add(name, kind, parent, mass, size, place, axis, com=(0.0, 0.0, 0.0), v0=()):
        bodies.append(Body(name, mass, com, box(mass, *size)))
        joints.append(Joint(f"{name}-joint", kind, parent, name, place, axis=axis, v0=v0))

    ex, ey = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    for i, x in enumerate((-7.0, 7.0)):
        add(f"main{i}", "prismatic", "world", 4.0e6, (10.0, 100.0, 80.0), (x, 0.0, 60.0), ex)
        add(f"upper{i}", "prismatic", f"main{i}", 3.0e5, (6.0, 12.0, 4.0), (0.0, 0.0, 17.0), ey)
        add(f"lower{i}", "prismatic", f"main{i}", 2.0e5, (5.0, 6.0, 4.0), (0.0, 0.0, 14.0), ey)
        drives += [Drive(f"{n}{i}-drive", f"{n}{i}-joint", "servo", KP, KV) for n in ("main", "upper", "lower")]
    v0 = (0.4, 0.3, 0.0, 0.010, -0.015, 0.020)
    add("block", "free", "world", 3.0e5, (20.0, 15.0, 10.0), (0.0, 0.0, 0.0), ex, v0=v0)
    joints[-1] = Joint("block-joint", "free", "world", "block", q0=(0.0, 0.0, 20.0, 0.0, 0.0, 0.0, 1.0), v0=v0)
    static = (3.0e5 + 6 * 5.0e3) * G / 6.0
    for i, x in enumerate((-7.0, 7.0)):
        for j, y in enumerate(hooks):
            n = 3 * i + j
            add(f"low{n}", "revolute", "block", 2.0e3, (1.0, 1.0, 1.0), (x, y, 5.0), ex, (0.0, 0.0, 0.5))
            add(f"up{n}", "revolute", f"low{n}", 3.0e3, (1.0, 1.0, 1.5), (0.0, 0.0, 1.0), ey, (0.0, 0.0, 0.75))
            springs += [JointSpring(f"{p}{n}-friction", f"{p}{n}-joint", d=HINGE_DAMPING) for p in ("low", "up")]
            trolley, z = (f"lower{i}", 74.0) if j == 1 else (f"upper{i}", 77.0)
            l = z - 2.0 - 27.5
            line = Line(Point(trolley, (0.0, y, -2.0)), Point(f"up{n}", (0.0, 0.0, 1.5)))
            ropes.append(Rope(f"rope{n}", (line,), EA, EA * l / (EA + static), ROPE_DAMPING))
    return System(tuple(bodies), tuple(joints), tuple(springs), drives=tuple(drives), ropes=tuple(ropes), gravity=G)
