"""Cells written apart from the effect library: their own chain, and departures in functional forms of their own."""
