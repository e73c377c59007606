"""Images to points: the checkerboard's corners, the stripe's centres, and what they show of the board."""
