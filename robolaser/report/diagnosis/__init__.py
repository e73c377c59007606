"""What a person sees of a diagnosis: one self-contained page, and a few lines on the terminal."""
