"""The parts of machines, and the messages between models.

messages                  all messages: orders, reports, samples, records
kernel_messages           inputs to the kernel, which change a simulation, and state events from it
parts                     the parts of machines, and how they are coupled
drive, winch              actors that move joints and wind ropes
gauges, rigging           actors: load cells, inclinometers and interlocks; slings, brakes and supports
"""

from heavylift.kernel.on_demand import face

face(__name__)
