"""Residual blocks: the rows of every sensor in every session, one after the other in one problem."""
