"""Parts of other programs' simulations, and the other way round: functional mock-up units (FMI), preCICE."""

from flexmb.fmi.cosimulation import Fmu, cosimulate
from flexmb.fmi.export import ports, write_fmu
from flexmb.fmi.model_exchange import ModelExchange
from flexmb.fmi.precice_run import CouplingMesh, couple

__all__ = ["CouplingMesh", "Fmu", "ModelExchange", "cosimulate", "couple", "ports", "write_fmu"]
