"""Sweeps over parameters on processes or a cluster; every run is a row of one table."""
