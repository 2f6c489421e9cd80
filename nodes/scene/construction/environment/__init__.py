"""What surrounds the lifts of a scene.

vessels     what floats in waves, and carries cranes and blocks
obstacles   floor and boxes that blocks meet
footings    what machines stand on, and their limits
touching    what the scene means to touch
"""
