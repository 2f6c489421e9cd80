"""Within the processes of a run: the moments of nodes and keeper, and of the coordinator; the blow, which they share.

striking, nodes, coordinator   the blow; who waits for its moment
command                        the command `heavylift` with all that imported
"""
