"""What takes part in a run: nodes made of models or of the kernel, in processes of their own or in the coordinator's.

participant         one node from WELCOME to BYE; node_process: a process of some of them
parts, building     the config that a WELCOME carries, and the model that it names
kernel_node         the kernel as a node
transitions         of models, as a data topic

Node processes import these modules one by one and nothing else of this room.
"""
