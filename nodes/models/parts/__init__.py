"""The parts of machines, and the messages between models.

messages                  orders, reports, samples, records: everything that travels
kernel_messages           inputs of the kernel, applied to a simulation, and its state events
parts                     the parts that machines are made of, and how they are wired
drive, winch, interlock   actors that move; what stops them
gauges, rigging           actors: load cells and inclinometers; slings, brakes, supports
"""

from heavylift.kernel.on_demand import face

face(__name__)
