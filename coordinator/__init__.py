"""Conservative time over Zenoh: processes, protocol, recording of a run, command line.

Lowest layer first
    protocol, transport     the decisions, without input or output; framed messages over Zenoh
    participants, hosts     nodes of models or of the kernel; processes on other hosts
    supervision             start, watch, replace, end processes
    live                    runs in progress: observers, an operator's orders
    verdict, record         the checks of a run, distances of shapes; its recording, or its samples and events in memory
    replay, ladder          replay of a recording; measured errors of a run, and the choice of its model level
    run                     one run
    trace, measured         wall time of a run by cause; comparison of a run with the log of a real crane
    uncertainty             errors of a run's figures, and what uncertain inputs do to them
    sweeps                  many runs of one scene on any engine
    workbench               a scene in a browser beside any editor
    commands, cli           the command `heavylift`; stopping: by signals
    face                    what `import heavylift` gives
"""
