"""Impossible scenes and orders, found before anything runs.

geometry         whether a scene fits
orders           orders that cannot be carried out in the state in which they are given
overloads        limits that are exceeded at rest
locked_checks    orders to joints that the scene's fidelity holds
findings         what was found, reported once per subject
"""
