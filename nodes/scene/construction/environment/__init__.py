"""The environment of the lifts of a scene: water, ground, obstacles and intended contacts.

vessels     vessels in waves, which carry cranes and blocks
hulls       free vessels with hydrodynamics from a file
fenders     faces against which vessels lean
obstacles   floor and boxes that blocks can touch
footings    bases of machines, and their limits
touching    intended contacts
"""
