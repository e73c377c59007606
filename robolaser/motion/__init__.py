"""Arms that move: why the real joint does not follow the simulated one."""
