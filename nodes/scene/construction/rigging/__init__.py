"""What hangs on machines made of parts.

slings     what entries are called: ropes of slings, lugs of blocks
tree       all rigging of a scene: slings, equalisers, frames, and where they are at the start
edges      edges as a rope meets them; ropes over a sheave or edges, and how high what holds them hangs
hooks      hook blocks on the ropes of a machine, and slings from one of them to lugs
hook_ratings  the limits of machines with hooks: loads, ropes, how they lead, travel
ratings    those of slings, shackles, frames and lugs, and of several machines together
"""
