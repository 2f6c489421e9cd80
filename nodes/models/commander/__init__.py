"""The commander: carries out the action list.

commander, orders     the atomic model: its list; orders to actors and their reports
conditions            evaluation of conditions, and sentences about what they wait for
jobs, order_checks    orders in progress; orders that cannot be carried out
actuator_registry     which machine owns which actuator, and the state at the start
turn_law              references of trolleys and winches while the block turns
"""

from heavylift.kernel.on_demand import face

face(__name__)
