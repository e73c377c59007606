"""What a person sees of a result: one self-contained page, and a few lines on the terminal."""
