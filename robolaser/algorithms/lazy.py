"""Factories of classes whose modules take long to import: they are imported with the first instance."""

from collections.abc import Callable
from importlib import import_module
from typing import Any


def lazy_factory(module: str, kind: str, **defaults: Any) -> Callable[..., Any]:
    """A function that makes instances of a class, with defaults of ours for settings that are not given."""

    def make(**settings: Any) -> Any:
        return getattr(import_module(module), kind)(**{**defaults, **settings})

    return make
