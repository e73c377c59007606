"""Fault models, one file a stage of the chain: those that the effect library names, and faults outside it."""

import importlib
import pkgutil

from robolaser.trials.synthetic.fault_model import FaultModel


def _all() -> tuple[type[FaultModel], ...]:
    for module in pkgutil.iter_modules(__path__):
        importlib.import_module(f"{__name__}.{module.name}")
    ours = [model for model in FaultModel.__subclasses__() if model.__module__.startswith(f"{__name__}.")]
    return tuple(sorted(ours, key=lambda model: model.effect))


OUTLIERS = "outliers"

FAULT_MODELS: dict[str, type[FaultModel]] = {model.effect: model for model in _all()}
"""By the name that the truth uses."""

UNMODELLED: tuple[str, ...] = ("cross_talk", "dead_zone", "dented_target", "hose", "hysteresis", "slipping")
"""Faults outside the library, which a diagnosis should call unexplained."""

MODELLED: tuple[str, ...] = tuple(name for name in FAULT_MODELS if name not in UNMODELLED and name != OUTLIERS)
"""What a diagnosis should name."""

BY_NAME: tuple[str, ...] = ("arm_scale", "focus_breathing", "target_stretch")
"""Those that are made when they are asked for alone: a seed gives the world that it always gave."""

DRAWN: tuple[str, ...] = tuple(name for name in MODELLED if name not in BY_NAME)
"""Those that are drawn where any may be."""
