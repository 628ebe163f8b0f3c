"""Models that are made from tables: serial arms by Denavit-Hartenberg parameters."""

from flexmb.mechanisms.serial_arm import ModifiedLink, StandardLink, serial_arm

__all__ = ["ModifiedLink", "StandardLink", "serial_arm"]
