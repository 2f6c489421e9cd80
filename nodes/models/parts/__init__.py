"""The parts of machines, and the messages between models.

messages                  all messages: orders, reports, samples, records
kernel_messages           inputs of the kernel, applied to a simulation, and its state events
parts                     the parts of machines, and how they are coupled
drive, winch              actors that move; interlocks that stop them
gauges, rigging           actors: load cells and inclinometers; slings, brakes, supports
"""

from heavylift.kernel.on_demand import face

face(__name__)
