"""The abstract simulator of Parallel DEVS.

simulator              one heap of distinct tags; internal, external or confluent
flatten, bags          coupled models dissolved into atomics with routes; messages into bags; who is due when
transitions            what is reported of each transition; what out ports promise, checked; what atomics say at a tag
rules                  outputs that change a state; rules that a model can break while it runs
canonical              states as bytes, without code in them; the state of a simulator
"""

from heavylift.kernel.on_demand import face

face(__name__)
