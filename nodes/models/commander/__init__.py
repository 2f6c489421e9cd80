"""The commander: carries out the action list.

commander, orders     the atomic model: its list; orders to actors and their reports
conditions            evaluation of conditions, and sentences about what they wait for
jobs, order_checks    orders in progress; orders that cannot be carried out
actuator_registry     which machine owns which actuator, and the state at the start
observed_state        the state of the lift as reported so far
turn_law              references of trolleys and winches while the block turns
order_rejected        the refusal of an order or a condition
"""

from heavylift.kernel.on_demand import face

face(__name__)
