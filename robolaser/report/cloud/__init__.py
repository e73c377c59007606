"""A cloud of points for people: one self-contained page, and a few lines on the terminal."""
