"""Gross errors: points that are not what they are taken for; a diagnosis finds and excludes them."""

from typing import Final

NAME: Final = "outliers"
WHERE: Final = "image"
TITLE: Final = "gross errors in some points"
REFERENCE: Final = "Hampel et al. 1986, Robust Statistics: 1-10 % in routine data"
