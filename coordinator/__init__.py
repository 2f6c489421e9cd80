"""Conservative time over Zenoh: processes, protocol, recording of a run, command line.

core        the protocol's decisions, without IO                node, memory        the node's side; both in one loop
hub, link   Zenoh sessions, framed and checked                  processes, keeper   the node processes of a run
run         one run from plan to recording                      cli                 the command `heavylift`
"""
