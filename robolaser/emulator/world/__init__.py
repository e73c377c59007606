"""What is in an emulated cell, and where it truly is."""
