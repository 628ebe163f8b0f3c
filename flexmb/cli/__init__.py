"""The command line: one file per verb, each a thin layer over the public functions."""

from flexmb.cli.command_line import main

__all__ = ["main"]
