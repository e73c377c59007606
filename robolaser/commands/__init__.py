"""What can be typed after `robolaser`, one file each: a command gathers, calls one function and shows the result.

A command's signature declares its options and its docstring explains them. It imports what it computes with inside the
function, so that `--help` and a wrong option cost no NumPy.
"""
