"""Which process and which host runs which nodes, and how processes of other hosts take part.

placement           nodes to processes
door, gate          where others may connect, and who may join
certificates, x509  by which both sides know each other
remote_node         the process at the other end

HOSTS.md tells it step by step.
"""
