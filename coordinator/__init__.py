"""Conservative time over Zenoh: processes, protocol, recording of a run, command line.

Lowest layer first
    protocol, transport     the decisions, without input or output; framed messages over Zenoh
    participants, hosts     what nodes are made of; processes on other hosts
    supervision             start, watch, replace, end processes
    live                    a run while it runs: observers, an operator's orders
    verdict, record         what was found in a run; what it puts on record
    replay, ladder          a recording runs again; what a run is wrong by, measured, and what is modelled for it
    run                     one run
    trace, measured         where the time of a run went; a run beside the log of a real crane
    sweeps                  many runs of one scene on any engine
    workbench               a scene in a browser beside any editor
    commands, cli           the command `heavylift`; stopping: by signals
    face                    what `import heavylift` gives
"""
