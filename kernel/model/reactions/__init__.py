"""Constraint analysis of a scene at one pose: rank, joint reactions, and the forces that rigid bodies leave
undetermined.

jacobian          the constraint Jacobian, scaled so that ranks can be distinguished from round-off
mobility          degrees of freedom from its rank
joint_reactions   force and moment of every joint; statically indeterminate forces, and the solution chosen
"""
