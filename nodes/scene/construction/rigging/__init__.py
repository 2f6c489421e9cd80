"""Rigging on machines made of parts.

tree       all rigging of a scene: slings, equalisers, frames, and their positions at the start
edges      edges over which ropes bend; ropes over sheaves or edges, and the height at which they hold their load
hooks      hook blocks on the ropes of a machine, and slings from one of them to lugs
hook_ratings  the limits of machines with hooks: loads, ropes, off-lead, travel
ratings    limits of slings, shackles, frames and lugs, and of several machines together
"""
