"""Machines of a cell: arms on a line, cameras, and the recorder that leads them."""
