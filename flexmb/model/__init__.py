"""Descriptions: the kinds of parts, markers, signals, materials, reduced bodies, and the model that holds them."""

from flexmb.model.material import MATERIALS, Material
from flexmb.model.modal_neutral_data import ModalNeutralData
from flexmb.model.model import Model
from flexmb.model.orbit import Orbit
from flexmb.model.orthotropic_material import OrthotropicMaterial
from flexmb.model.pose import Pose

__all__ = ["MATERIALS", "Material", "ModalNeutralData", "Model", "Orbit", "OrthotropicMaterial", "Pose"]
