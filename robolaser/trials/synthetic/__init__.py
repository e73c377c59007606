"""Cells written apart from the effect library: their own chain, and faults in functional forms of their own."""
