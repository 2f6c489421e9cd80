"""Classic DEVS models as examples, small enough to be read at once and to be copied.

queue                generator, processor, transducer, and the experimental frame around a processor
multi_server_queue   M/M/c with feedback: random streams, statistics, results
bouncing_ball        a hybrid atomic model: a differential equation with state events
traffic_light        a traffic light that an operator can control: one atomic model with phases
anti_sway            a PID controller that damps the swing of a load, for the key `models` of a scene
token_ring           stations that pass on a token: a cycle of atomic models
"""

from heavylift.kernel.on_demand import face

face(__name__)
