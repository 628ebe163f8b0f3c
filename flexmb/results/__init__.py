"""What came out: the solution, its file, and the recovery of displacement and stress from flexible coordinates."""

from flexmb.results import recover
from flexmb.results.phase import Instant, Phase
from flexmb.results.read_file import stored_body, stored_samples
from flexmb.results.run_file import RunFile, floating_data
from flexmb.results.series import MarkerMotion, Series
from flexmb.results.solution import SHARED, Solution
from flexmb.results.status import STORED, Status
from flexmb.results.wear import Wear, wear

__all__ = [
    "SHARED",
    "STORED",
    "Instant",
    "MarkerMotion",
    "Phase",
    "RunFile",
    "Series",
    "Solution",
    "Status",
    "Wear",
    "floating_data",
    "recover",
    "stored_body",
    "stored_samples",
    "wear",
]
