"""Arms that a physics engine moves: what gives way comes to rest by MuJoCo's dynamics, not by a formula."""
