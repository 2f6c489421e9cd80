"""Assembly: closing the kinematic loops of a scene at the start of a run, and checking that they stay closed.

start_pose   initial pose: given coordinates are kept where possible
assembly     closing the loops of an initial pose, or reporting their gaps; why loops are lost
"""
