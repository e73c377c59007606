"""The commands of `robolaser`, one file each: a command reads its inputs, calls one function and shows the result.

A command's signature declares its options and its docstring explains them. It imports libraries inside the
function, so that `--help` and a wrong option do not load NumPy.
"""
