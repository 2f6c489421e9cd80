"""Forces: one entry of the force table each, and the laws of ropes, supports, stops and brakes.

table, force_law        the force table; what the kernel asks of a kind of force
laws                    ropes, supports, stops, brakes and drives between events
springs, loads          springs, dampers and bushings; loads that are given, and wind
characteristic          actuator laws given as data
reeving, rope_groups, sheaves   ropes over sheaves with friction; their parts; their geometry
rope_mass               what the ends of a rope bear of its mass
user_laws, mathematics  laws of the user's own, and what they may compute with
"""
