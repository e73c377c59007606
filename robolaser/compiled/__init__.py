"""Loops that a compiler makes as fast as the machine goes: when they pay, and how they share its cores.

A module `*_loops.py` holds numba's functions on plain arrays; each has a readable twin in NumPy beside its caller, and
both agree to rounding. NumPy answers until a process has had work enough for the compiled loops to pay, and until
they are compiled: that happens in another process, once for each version of the source, and nobody waits for it.
"""

from robolaser.compiled.loops import Loops, compiles
from robolaser.compiled.threads import cores, share_out

__all__ = ["Loops", "compiles", "cores", "share_out"]
