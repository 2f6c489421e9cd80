"""Functions called in a loop of machine code, so that timings contain no Python call."""

import ctypes
import re
import time

import llvmlite.binding as llvm
import numpy as np
from heavylift.kernel.compiler import Library
from heavylift.kernel.simulation import Simulation

RUNS = 15  # of which the fastest counts: other work on the machine only ever adds

_LOOP = """
define void @loop({parameters}, i64 %times) {{
entry:
  br label %head
head:
  %i = phi i64 [0, %entry], [%next, %head]
  call void {call}
  %next = add i64 %i, 1
  %more = icmp slt i64 %next, %times
  br i1 %more, label %head, label %exit
exit:
  ret void
}}
"""


def fastest(work, times, runs=RUNS):
    """Seconds of CPU of one of `times` repetitions."""
    best = np.inf
    for _ in range(runs):
        began = time.thread_time()
        work(times)
        best = min(best, (time.thread_time() - began) / times)
    return best


def evaluation(simulation: Simulation, fused=False, times=2000, runs=RUNS):
    """Seconds of one evaluation of the equations of motion, and bytes of the machine code of the whole scene."""
    text = simulation.method.ir(fused)
    parameters = re.search(r"define void @rate\((.*?)\)", text).group(1).replace("noalias ", "")
    code = Library("", lambda: text + _LOOP.format(parameters=parameters, call=f"@rate({parameters})"), cache=False)
    names = re.findall(r"%(\w+)", parameters)
    sizes = {"G": len(simulation.program.guards), "T": len(simulation.program.system.ropes)}
    blocks = {k: np.zeros(max(sizes.get(k, 0), simulation.program.ny)) for k in names}
    blocks["t"], blocks["y"], blocks["P"] = np.zeros(2), simulation.state.copy(), simulation.P.copy()
    loop = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * len(names), ctypes.c_long)(code.address("loop"))
    return fastest(lambda n: loop(*[blocks[k].ctypes.data for k in names], n), times, runs), code.size


def foreign(address, *pointers, times=1000):
    """Seconds of one call of a C function of pointers."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    parameters = ", ".join(f"ptr %p{i}" for i in range(len(pointers)))
    target = f"inttoptr (i64 {address} to ptr)({parameters})"
    code = Library("", lambda: _LOOP.format(parameters=parameters, call=target), cache=False)
    loop = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * len(pointers), ctypes.c_long)(code.address("loop"))
    return fastest(lambda n: loop(*pointers, n), times)
