"""Plane profiles: cams, tracks, teeth, racks."""

from flexmb.profiles.cam import Cam
from flexmb.profiles.outline import Disc, Outline, SmoothOutline
from flexmb.profiles.pieces import Arc, Involute, Line, Spline
from flexmb.profiles.profile import Profile
from flexmb.profiles.slot import Slot

KINDS = {kind.__name__: kind for kind in (Arc, Cam, Disc, Involute, Line, Outline, Slot, SmoothOutline, Spline)}
"""Profiles and their pieces by name, as they are written in model files."""

__all__ = ["KINDS", "Profile", *KINDS]
