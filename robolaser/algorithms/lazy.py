"""Makers of things whose modules take long to import: they are imported when the first is made."""

from collections.abc import Callable
from importlib import import_module
from typing import Any


def lazily(module: str, kind: str, **usual: Any) -> Callable[..., Any]:
    """Make a class's instances, with settings that are the usual ones where nothing else is said."""

    def make(**settings: Any) -> Any:
        return getattr(import_module(module), kind)(**{**usual, **settings})

    return make
