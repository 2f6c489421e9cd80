"""Force elements beyond ropes, supports, stops and brakes: one entry of the force table each.

describe              every kind as plain data
table                 the force table: what the kernel asks of a kind; equal ones share one traced function
histories             time histories of signals: the active piece in P, breakpoints as step boundaries
loads, springs, ...   the entries: the laws themselves
"""
