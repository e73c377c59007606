"""Compile loops for later runs, in a process of its own: `python -m robolaser.compiled MODULE...`."""

import os
import sys

from robolaser.compiled.loops import compile_now

if __name__ == "__main__":
    os.nice(10)
    for name in sys.argv[1:]:
        compile_now(name)
