"""The report of a comparison: one self-contained page, and a few lines on the terminal."""
