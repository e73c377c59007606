"""Rankings of solvers: which is better, by how much, and how certain that is."""
