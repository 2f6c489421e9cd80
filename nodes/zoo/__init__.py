"""Classic DEVS models, small enough to be read at once and to be copied from.

queue           generator, processor, transducer, and the experimental frame around a processor
traffic_light   a light that an operator can take over: one atomic with phases
token_ring      stations that pass a token on: a cycle of atomics
"""
