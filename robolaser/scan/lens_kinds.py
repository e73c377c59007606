"""Kinds of distortion that the compiled loop over a cloud's points takes off, by the number that it knows them by."""

RADIAL = 1.0
TANGENTIAL = 2.0
