"""Reports of results: one self-contained page, and a few lines on the terminal."""
