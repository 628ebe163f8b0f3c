"""Sweeps over parameters on processes or a cluster; every run is a row of one table."""

from flexmb.study.cluster import dask_executor
from flexmb.study.outputs import REDUCTIONS
from flexmb.study.plan import Plan, grid, latin_hypercube, listed, range_values, read_plan
from flexmb.study.sources import FunctionSource, ModelFile, function_in
from flexmb.study.sweeping import sweep
from flexmb.study.table import Results, Row

__all__ = [
    "REDUCTIONS",
    "FunctionSource",
    "ModelFile",
    "Plan",
    "Results",
    "Row",
    "dask_executor",
    "function_in",
    "grid",
    "latin_hypercube",
    "listed",
    "range_values",
    "read_plan",
    "sweep",
]
