"""The environment of the lifts of a scene.

vessels     vessels in waves, which carry cranes and blocks
hulls       free vessels by a file of hydrodynamics
obstacles   floor and boxes that blocks can touch
footings    bases of machines, and their limits
touching    intended contacts
"""
