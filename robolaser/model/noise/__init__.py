"""How much of a residual is measurement error."""
