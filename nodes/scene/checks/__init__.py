"""What cannot be, found before anything runs.

geometry         whether a scene fits
orders           orders that nobody can carry out where the lift stands when they are given
locked_checks    orders to joints that the scene's fidelity holds
findings         what was found, told once per subject
"""
