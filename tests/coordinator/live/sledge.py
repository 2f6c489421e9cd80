"""A sledge on a rail: the smallest scene that an operator can say something to."""

SLEDGE = """\
heavylift: 1
name: sledge
mechanism:
  name: sledge
  bodies:
    cart: {mass: 4 t}
  joints:
    rail: {type: prismatic, child: cart, axis: [1, 0, 0]}
  drives:
    pusher: {joint: rail, type: servo, stiffness: 1 MN/m, damping: 0.4 MN s/m, ramp: 0.5 m/s2, range: [-50 m, 50 m]}
actions:
  - stage: out
    pusher: drive 30 m/min by 1 m
  - stage: rest
    wait: 2 s
  - stage: back
    pusher: drive 30 m/min by -1 m
"""
