"""What a person sees of a calibration: one self-contained page, and a few lines on the terminal."""
