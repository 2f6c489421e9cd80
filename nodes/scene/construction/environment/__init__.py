"""The environment of the lifts of a scene.

vessels     vessels in waves, which carry cranes and blocks
obstacles   floor and boxes that blocks can touch
footings    bases of machines, and their limits
touching    intended contacts
"""
