"""The faults of blind trials, one file a part of the cell: those that the effect library names, and others."""

import importlib
import pkgutil
from typing import Final

from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.fault_models.loads import SpringFault

for _module in pkgutil.iter_modules(__path__):
    importlib.import_module(f"{__name__}.{_module.name}")


def _all(above: type[FaultModel]) -> list[type[FaultModel]]:
    """The fault models of this package below a class."""
    below = [model for child in above.__subclasses__() for model in (child, *_all(child))]
    return [model for model in below if model.form and model.__module__.startswith(f"{__name__}.")]


OUTLIERS: Final = "outliers"

FAULT_MODELS: dict[str, type[FaultModel]] = {  # by their names as kinds of worlds
    model.form: model for model in sorted(_all(FaultModel), key=lambda m: m.form)
}

PHYSICAL: tuple[str, ...] = tuple(model.form for model in SpringFault.__subclasses__())
"""Faults simulated in MuJoCo; the others have formulas."""

UNMODELLED: tuple[str, ...] = ("cross_talk", "dead_zone", "dented_target", "hose", "hysteresis", "slipping")
"""Faults in formulas outside the library, which a diagnosis should call unexplained."""

MODELLED: tuple[str, ...] = tuple(name for name in FAULT_MODELS if name not in (*PHYSICAL, *UNMODELLED, OUTLIERS))
"""Faults that a diagnosis should name."""

BY_NAME: tuple[str, ...] = ("arm_scale", "focus_breathing", "mount_shift", "target_stretch")
"""Faults that are made on request only, so that a seed keeps its world."""

DRAWN: tuple[str, ...] = tuple(name for name in MODELLED if name not in BY_NAME)  # for random draws
