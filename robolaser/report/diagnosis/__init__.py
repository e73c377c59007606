"""The report of a diagnosis: one self-contained page, and a few lines on the terminal."""
