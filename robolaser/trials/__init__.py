"""Blind trials: data sets whose departures from the model are sealed, and the score of a diagnosis on them."""
