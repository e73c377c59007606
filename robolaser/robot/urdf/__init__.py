"""Robots described as text (URDF): checked before Pinocchio reads them, written and rewritten."""
