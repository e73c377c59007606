"""The machines of a cell: arms on a line, cameras, and the recording of what they do. Importing opens nothing."""
