"""Kinds of faults that faults.py injects around a run, and the promised outcome of each.

trial, workloads, leftovers   one injection in a folder of its own; the runs that are disturbed; what they leave behind
inside                        within the processes of a run: the moments of a case, the blow
processes                     every process, in every way, at every moment
disk, files                   no space, no rights, no folder; recordings that change or are cut
bus, hosts, line              frames, sockets; processes of other hosts and the line to them
environment, starting         variables, limits and names; how a process is started
table                         rows of all kinds
"""
