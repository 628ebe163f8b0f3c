"""Models that are made from tables and meshes: serial arms by Denavit-Hartenberg parameters, networks of lines."""

from flexmb.mechanisms.line_network import LineNetwork, line_network
from flexmb.mechanisms.serial_arm import ModifiedLink, StandardLink, serial_arm

__all__ = ["LineNetwork", "ModifiedLink", "StandardLink", "line_network", "serial_arm"]
