"""The report of a calibration: one self-contained page, and a few lines on the terminal."""
