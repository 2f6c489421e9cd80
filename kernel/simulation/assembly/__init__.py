"""Closing of loops: at the start of a run, and after each step.

start_pose   initial pose: given coordinates are kept where possible
assembly     closing the loops of an initial pose, or reporting their gaps; why loops are lost
"""
