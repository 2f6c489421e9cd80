"""Loops closed: at the start of a run, and after each step.

start_pose   what was asked stays where it can
assembly     loops of an initial pose closed, or how wide they gape; why they are lost
"""
