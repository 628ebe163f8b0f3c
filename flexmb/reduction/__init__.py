"""FE model to modal neutral data: Craig-Bampton, inertia invariants, geometric stiffness, load shapes, report."""

from flexmb.math.foreign_factor import Cholmod, Pardiso
from flexmb.model.changed_data import mirrored, moved, rescaled
from flexmb.model.modal_neutral_report import report
from flexmb.reduction.craig_bampton import reduce
from flexmb.reduction.damping import Bands, Rayleigh
from flexmb.reduction.interfaces import Averaging, Nodes, Rigid
from flexmb.reduction.loads import LineLoad, NodalForces, Pressure
from flexmb.reduction.mode_choice import UpTo
from flexmb.reduction.split import split

__all__ = [
    "Averaging",
    "Bands",
    "Cholmod",
    "LineLoad",
    "NodalForces",
    "Nodes",
    "Pardiso",
    "Pressure",
    "Rayleigh",
    "Rigid",
    "UpTo",
    "mirrored",
    "moved",
    "reduce",
    "report",
    "rescaled",
    "split",
]
