"""From images to points: the checkerboard's corners, and the stripe's centres on the board."""
