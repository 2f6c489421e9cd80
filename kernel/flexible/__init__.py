"""Flexible bodies: linear elastic modes in a floating frame that moves freely.

description, checks   what a user gives: a beam, or matrices of a finite-element model; needs no NumPy
beam, modes           finite elements, their modes, shapes at stations
eigenmodes, algebra,
polynomials           how they are computed with the same bits on every processor
reduction, numbers    the constants of the kinetic energy, rounded
inertia               those constants in the recursion
small_deflections,
buckling              where the theory ends: deflections and turns within a body, compression
attachment, stations  frames carried by the modes at a place, and at a coordinate that slides
This package names nothing of its own: the kernel imports its modules one by one, so that descriptions load no NumPy.
"""
