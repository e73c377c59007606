"""Data sets: the folder, its files, and what is read from them.

Raises (every function that reads or checks): DataError with file, row and column of what is missing or wrong; (every
function that writes) OutputError where the disk or its rights refuse.
"""
