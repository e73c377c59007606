"""The contents of an emulated cell, with their true positions."""
