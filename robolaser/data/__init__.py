"""Data sets: the folder, its files, and what is read from them."""
