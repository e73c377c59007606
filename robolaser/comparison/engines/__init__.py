"""Where runs happen: on this machine's cores, or on a Dask cluster."""

from robolaser.comparison.engines.dask_cluster import DaskCluster
from robolaser.comparison.engines.engine import Engine, Parcel
from robolaser.comparison.engines.this_machine import ThisMachine
from robolaser.comparison.task import Task

__all__ = ["DaskCluster", "Engine", "Parcel", "Task", "ThisMachine"]
