"""What a person sees of a comparison: one self-contained page, and a few lines on the terminal."""
