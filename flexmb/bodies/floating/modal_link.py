"""A floating body as a link of a tree, if its mass is the same in all directions."""

from __future__ import annotations

import numpy as np

from flexmb.bodies.floating.row import mean_of_modes
from flexmb.model.modal_link import ModalLink

__all__ = ["modal_link"]

ALIKE = 1e-10
"""Difference of masses that count as the same, relative."""


def modal_link(body) -> ModalLink | None:
    """Return a `FloatingBody` as a link; None if mass is missing in a direction (planar meshes)."""
    data = body.reduced
    m, i, g, groups = data.n_modes, data.invariants, data.geometric, body.stiffening_groups
    if not np.allclose(i.vv, data.mass * np.eye(3), rtol=0.0, atol=ALIKE * data.mass):
        return None
    acts = {name: g is not None and name in groups for name in ("inertia", "interface", "loads", "preload")}
    ww2 = 0.5 * (i.ww2 + np.swapaxes(i.ww2, 0, 1))
    turning = data.load_turning if data.load_turning is not None else np.zeros((0, 6 + m, m))
    if data.preload_turning is not None and "preload" in groups:
        missing = np.zeros((len(data.load_names) - len(turning), 6 + m, m))
        turning = np.concatenate([turning, missing, data.preload_turning[None]])
    poses = list(body.marker_poses().values())

    def symmetric(matrices):
        return 0.5 * (matrices + np.swapaxes(matrices, -1, -2))

    return ModalLink(
        mass=data.mass,
        vw0=i.vw0,
        ww0=symmetric(i.ww0),
        vw1=i.vw1,
        vn=i.vn,
        wn0=i.wn0,
        ww1=i.ww1,
        ww2=symmetric(ww2),
        wn1=i.wn1,
        nn=i.nn,
        stiffness=data.stiffness,
        damping=body.damping_matrix(),
        mean=mean_of_modes(i),
        inertia_stiffening=symmetric(g.inertia) if acts["inertia"] else np.zeros((0, m, m)),
        interface_stiffening=symmetric(g.interface) if acts["interface"] else np.zeros((0, 6, m, m)),
        load_stiffening=symmetric(g.loads) if acts["loads"] else np.zeros((0, m, m)),
        preload_stiffening=symmetric(g.preload) if acts["preload"] else np.zeros((m, m)),
        load_shapes=data.load_shapes,
        load_turning=turning,
        positions=np.array([pose.at for pose in poses], float).reshape(-1, 3),
        axes=np.array([pose.matrix for pose in poses], float).reshape(-1, 3, 3),
        translations=data.marker_translations,
        rotations=data.marker_rotations,
    )
