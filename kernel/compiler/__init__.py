"""From plain Python functions to machine code: tracing, LLVM IR, compilation.

symbol, function              symbols that record arithmetic; functions traced once; named parts of blocks of numbers
derivative                    derivatives of recorded functions, along many directions at once
emit                          recorded functions as an LLVM IR module; machine code of this process, cached
llvm_function                 one function as straight-line code
simd_batches                  equal calls side by side as vectors; loads of their operands
vector_loops                  arithmetic on whole states as loops
native_loops, native_linear_algebra   loops written by hand; LU factors of dense systems
"""

from heavylift.kernel.on_demand import face

face(__name__)
