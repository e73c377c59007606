"""A cell in the browser."""
