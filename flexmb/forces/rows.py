"""What forces share: given components, central forces between two points, follower loads,
the law of a one-sided contact.
"""

from __future__ import annotations

from flexmb.errors import ModelError
from flexmb.math.kernel import kernel
from flexmb.model.described import entries_of
from flexmb.model.signal import as_signal

__all__ = [
    "add_central_block",
    "add_follower_stiffness",
    "apply_central_force",
    "one_sided",
    "require_center_of_mass",
    "require_centre",
    "store_three_signals",
]


@kernel
def apply_central_force(a, b, direction, force):
    """Pull marker b towards marker a with `force` (N) along the unit `direction` from a to b."""
    for i in range(3):
        a.wrench[i] += force * direction[i]
        b.wrench[i] -= force * direction[i]


@kernel
def add_follower_stiffness(K, top, load):
    """Add to the pair's K (12, 12) that a load (3,), at the rows `top`, turns with marker b: dF = dtheta x F."""
    K[top, 10] -= load[2]
    K[top, 11] += load[1]
    K[top + 1, 9] += load[2]
    K[top + 1, 11] -= load[0]
    K[top + 2, 9] -= load[1]
    K[top + 2, 10] += load[0]


@kernel
def add_central_block(matrix, along, across, e):
    """Add the (3, 3) block along e e^T + across (I - e e^T) with the signs of a force between two points."""
    for i in range(3):
        for j in range(3):
            k = (along - across) * e[i] * e[j]
            if i == j:
                k += across
            matrix[i, j] += k
            matrix[6 + i, 6 + j] += k
            matrix[i, 6 + j] -= k
            matrix[6 + i, j] -= k


@kernel
def one_sided(p, rate, stiffness, exponent, damping, depth):
    """Return the force of a penetration p, its derivatives by p and by the rate p', and the energy stored.

    ``F = k p^e + c w(p/d) p'``, eq. (one-sided), with ``w(s) = s^2 (3 - 2 s)`` up to s = 1; never pulling.
    """
    if p <= 0.0:
        return 0.0, 0.0, 0.0, 0.0
    s = min(p / depth, 1.0)
    share = s * s * (3.0 - 2.0 * s)
    energy = stiffness * p ** (exponent + 1.0) / (exponent + 1.0)
    force = stiffness * p**exponent + damping * share * rate
    if force <= 0.0:
        return 0.0, 0.0, 0.0, energy
    slope = stiffness * exponent * p ** (exponent - 1.0) + damping * 6.0 * s * (1.0 - s) / depth * rate
    return force, slope, damping * share, energy


def store_three_signals(force, field: str) -> None:
    """Make the field a tuple of three signals; ModelError unless it holds three numbers or signals."""
    value = getattr(force, field)
    entries = () if isinstance(value, str) else entries_of(value)
    if len(entries) != 3:
        raise ModelError(
            force.title,
            found=f"{field} = {value!r}",
            expected="three numbers or signals (x, y, z)",
            remedy=f"Write {field}=(0, 0, -100.0)",
        )
    object.__setattr__(force, field, tuple(as_signal(v, force.title, f"{field}[{i}]") for i, v in enumerate(entries)))


def require_center_of_mass(force, model, elastic: bool = False) -> None:
    """Raise ModelError unless the field `body` names one with a centre of mass, or with `elastic` a reduced one, and
    `source` is on the ground.
    """
    body = model.body(force.body, force.title)
    reduced = elastic and body.reduced is not None
    if not reduced and (not hasattr(body, "mass") or "center" not in body.marker_poses()):
        raise ModelError(
            force.title,
            found=f"'{force.body}', {type(body).__name__}",
            expected="a RigidBody or a PointMass" + (" or a FloatingBody" if elastic else ""),
            remedy="Name such a body; elastic ones take loads at their markers",
        )
    if hasattr(force, "source"):
        require_centre(force, model)


def require_centre(force, model) -> None:
    """Raise ModelError unless the field `source` is on the ground, with an orbit at the origin of W."""
    holder, pose = model.marker(force.source, force.title)
    if model.origin is not None and any(pose.at):
        raise ModelError(
            force.title,
            found=f"source = '{force.source}', at {tuple(pose.at)} m, in a model whose origin falls along an orbit",
            expected="a ground marker at the origin of W: the orbit says where the centre is",
            remedy="Leave source out, or place its marker at (0, 0, 0)",
        )
    if holder.n_velocities:
        raise ModelError(
            force.title,
            found=f"source = '{force.source}', on a body that moves",
            expected="a centre on the ground",
            remedy="Write source='ground.marker'",
        )


@kernel
def hunt_crossley(p, rate, stiffness, exponent, damping):
    """Return the force ``k p^e (1 + D p')`` of a penetration p > 0, never pulling, and what follows from it.

    These are its derivatives by p and by the rate p', and the elastic part k p^e. Hunt & Crossley 1975, eq. 12.
    """
    elastic = stiffness * p**exponent
    growth = 1.0 + damping * rate
    if growth <= 0.0:
        return 0.0, 0.0, 0.0, elastic
    return elastic * growth, stiffness * exponent * p ** (exponent - 1.0) * growth, elastic * damping, elastic
