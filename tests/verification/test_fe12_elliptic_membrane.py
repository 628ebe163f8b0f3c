"""FE12, NAFEMS LE1: elliptic membrane under outward pressure; sigma_yy at D (2, 0) by shell membranes.

NAFEMS, Standard Benchmarks (1990): 92.7 MPa. The solid part of the case (LE10) is in
test_fe12_thick_plate_pressure.py.
"""

from dataclasses import replace

import numpy as np
import pytest
from fem.beams import on, plate

from flexmb import fem
from flexmb.model.material import Material

TOLERANCE = 0.02
T, PRESSURE = 0.1, 10e6


@pytest.mark.parametrize(("kind", "around", "across"), [("quad", 32, 24), ("cross", 32, 24), ("triangle", 32, 24)])
def test_stress_at_the_inner_edge(reference, kind, around, across):
    mesh = plate(around, across, 1.0, 1.0, kind)
    angle, outwards = mesh.points[:, 0] * np.pi / 2, mesh.points[:, 1:2]
    inner = np.stack([2.0 * np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    outer = np.stack([3.25 * np.cos(angle), 2.75 * np.sin(angle), 0 * angle], axis=1)
    fe = fem.shell(
        replace(mesh, points=inner + outwards * (outer - inner)),
        Material(young=210e9, poisson=0.3, density=1.0),
        T,
    )
    load = np.zeros((len(fe.nodes), 6, 1))
    edge = np.flatnonzero(mesh.points[:, 1] == 1.0)
    edge = edge[np.argsort(mesh.points[edge, 0])]
    along = fe.nodes[edge[1:]] - fe.nodes[edge[:-1]]
    share = 0.5 * PRESSURE * T * np.stack([along[:, 1], -along[:, 0], 0 * along[:, 0]], axis=1)
    for nodes in (edge[1:], edge[:-1]):
        np.add.at(load[:, :3, 0], nodes, share)
    held = fem.with_supports(fe, directions=(2, 3, 4))
    held = fem.with_supports(fem.with_supports(held, on(fe, 0, 0.0), (0, 5)), on(fe, 1, 0.0), (1, 5))
    field = held.field(fem.static(held, held.forces(load), None))
    point = np.linalg.norm(fe.nodes - [2.0, 0.0, 0.0], axis=1).argmin()
    stress = fe.blocks[0].nodal_stress(field)[point, 1, 0]
    assert stress / 1e6 == pytest.approx(reference("FE12")["reference"]["LE1_MPa"], rel=TOLERANCE)
