"""FE model to modal neutral data: Craig-Bampton, inertia invariants, geometric stiffness, load shapes, report."""

from flexmb.math.foreign_factor import Cholmod, Pardiso
from flexmb.model.changed_data import mirrored, moved, rescaled
from flexmb.model.modal_neutral_report import report
from flexmb.reduction.assembled import assembled
from flexmb.reduction.bases import Balanced, CharacteristicModes, CraigBampton, Krylov, Pod, Rubin
from flexmb.reduction.contact_zone import ContactZone
from flexmb.reduction.craig_bampton import reduce
from flexmb.reduction.damping import Bands, Rayleigh
from flexmb.reduction.interfaces import Averaging, Nodes, Rigid
from flexmb.reduction.load_clouds import LoadCloud
from flexmb.reduction.load_tables import LineTable, PressureTable
from flexmb.reduction.loads import LineLoad, NodalForces, Pressure
from flexmb.reduction.mode_choice import UpTo
from flexmb.reduction.snapshots import Motion, snapshots_of
from flexmb.reduction.split import split
from flexmb.reduction.surface_pressure import SurfacePressure
from flexmb.reduction.tracks import Track

__all__ = [
    "Averaging",
    "Balanced",
    "Bands",
    "CharacteristicModes",
    "Cholmod",
    "ContactZone",
    "CraigBampton",
    "Krylov",
    "LineLoad",
    "LineTable",
    "LoadCloud",
    "Motion",
    "NodalForces",
    "Nodes",
    "Pardiso",
    "Pod",
    "Pressure",
    "PressureTable",
    "Rayleigh",
    "Rigid",
    "Rubin",
    "SurfacePressure",
    "Track",
    "UpTo",
    "assembled",
    "mirrored",
    "moved",
    "reduce",
    "report",
    "rescaled",
    "snapshots_of",
    "split",
]
