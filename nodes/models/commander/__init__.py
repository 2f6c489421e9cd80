"""The commander, which carries out the action list.

commander, orders     the atomic model of the commander; its orders to actors, and their reports
conditions            evaluation of conditions, and sentences about what they wait for
jobs, order_checks    orders in progress; checks that refuse orders that cannot be carried out
actuator_registry     the machine that owns each actuator, and the state at the start
turn_law              references of trolleys and winches while the block is turned
"""

from heavylift.kernel.on_demand import face

face(__name__)
