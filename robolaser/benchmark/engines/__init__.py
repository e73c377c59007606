"""Where jobs are done: on this machine's cores, or on a Dask cluster."""

from robolaser.benchmark.engines.dask_cluster import DaskCluster
from robolaser.benchmark.engines.engine import Engine, EngineLost, Job
from robolaser.benchmark.engines.this_machine import ThisMachine

__all__ = ["DaskCluster", "Engine", "EngineLost", "Job", "ThisMachine"]
