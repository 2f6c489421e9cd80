"""Constraints of a scene at one pose: rank, what they transmit, and what of it rigid bodies do not determine.

jacobian          the constraint Jacobian, scaled so that ranks can be reported
mobility          degrees of freedom by its rank
joint_reactions   force and moment of every joint; what statics does not determine, and the choice that is made
"""
