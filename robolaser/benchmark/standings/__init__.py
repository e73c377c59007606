"""Rankings of solvers: which is better, by how much, and with which certainty."""
