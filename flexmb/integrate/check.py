"""`check`: what a model is, before anything is simulated."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from flexmb.errors import CompileError
from flexmb.integrate.overlaps import overlaps
from flexmb.integrate.oversights import oversights
from flexmb.math.tables import State
from flexmb.model.model import Model
from flexmb.system import assemble_as_drawn, mobility
from flexmb.system.branching import Branching, branching
from flexmb.system.complaints import begins_elsewhere
from flexmb.system.program import evaluate
from flexmb.system.system import System

__all__ = ["Report", "check"]

FAR = 0.02
"""Motion of a body in assembly, relative to the model's size, that is no small misfit of a drawing."""


OTHERS = {
    "Distance": "force along the line",
    "NoTwist": "moment about the line",
    "Angle": "moment of the drive",
    "Coupled": "force or moment of the coupling",
    "Formula": "force of its equation",
    "Loop": "force or moment around the loop",
    "Meshing": "force between the teeth",
    "OnCurve": "force across the curve",
    "OnPath": "force across the path",
    "Touching": "force of the contact",
}
"""What other equations hold."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Report:
    """The findings of `check`.

    Parameters
    ----------
    model : Model
    mobility : int
        True number of degrees of freedom: velocities minus independent equations.
    gruebler : int
        Count of Grübler and Kutzbach: velocities minus all equations.
    velocities, equations : int
    redundant : tuple of str
        Names of the equations that depend on others; their multipliers are not unique (least norm is reported).
    assembly_error : float, m or rad
        Largest residual of the constraints as described, before assembly.
    moved : float, m or rad
        Largest increment of a coordinate that assembly made.
    indeterminate : tuple of str
        Names of the equations whose multipliers are not unique: the dependent ones and all that share a state of
        self-stress with them.
    notes : tuple of str
        What is perhaps not meant: bodies that nothing holds, no gravity, a body that assembly moved.
    warnings : tuple of str
        What is hardly meant: joints that are drawn open by a hundredth of the model's size (by a tenth it is an error),
        velocities that contradict joints.
    singular : Branching or None
        Where motions branch at the start: instantaneous freedoms, finite ones, and the joints concerned.
    misfits : dict of joint name to (float, float), m and rad
        What dependent equations leave open because they contradict each other within the digits of a mesh file (1e-6 of
        the model's size); larger gaps are an error. The motion ignores them, and they stress nothing.
    assembled : tuple of System and State, or None
        The consistent start, for `first_frequencies(model, about=report)`; None where no motion goes on from it.
    """

    model: Model
    mobility: int
    gruebler: int
    velocities: int
    equations: int
    redundant: tuple[str, ...]
    assembly_error: float
    moved: float
    misfits: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    indeterminate: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    singular: Branching | None = None
    assembled: tuple[System, State] | None = None

    @property
    def shared_reactions(self) -> dict[str, list[str]]:
        """The primitive equations whose reactions are not unique, by joint."""
        found: dict[str, list[str]] = {}
        for name in self.indeterminate:
            joint, _, kind = name.rpartition(": ")
            found.setdefault(joint, []).append(kind)
        return found

    @property
    def shared_loads(self) -> dict[str, list[str]]:
        """What these equations hold, as forces and moments, by joint: "force along z", "moment about y"."""
        return {joint: [_load(kind) for kind in kinds] for joint, kinds in self.shared_reactions.items()}

    def __repr__(self) -> str:
        return str(self)

    def __str__(self) -> str:
        m = self.model
        lines = [
            f"Model '{m.name}': {len(m.bodies)} bodies, {len(m.joints)} joints, {len(m.forces)} forces",
            f"  velocities {self.velocities}, constraint equations {self.equations}",
            f"  mobility {self.mobility} (Grübler-Kutzbach count {self.gruebler})",
            f"  assembly error as described {self.assembly_error:.3g}, largest motion of assembly {self.moved:.3g}",
        ]
        if self.redundant:
            lines.append(f"  {len(self.redundant)} dependent equations:")
            lines += [f"    {joint}: {_load(kind)}" for joint, _, kind in (n.rpartition(": ") for n in self.redundant)]
            lines.append("  Reactions that are not unique with them (least norm is given), by joint:")
            lines += [f"    {joint}: {', '.join(kinds)}" for joint, kinds in self.shared_loads.items()]
            lines.append("  To make reactions unique, replace one of the joints concerned by one that forbids less,")
            lines.append("  for example a Revolute by a Cylindrical, Universal or Spherical joint.")
        if self.misfits:
            lines.append(
                "  They contradict each other within mesh tolerance; left open, without stress, are the joints"
            )
            lines += [
                f"    {name}: {metres:.2g} m, {radians:.2g} rad" for name, (metres, radians) in self.misfits.items()
            ]
        if self.singular is not None:
            lines.append(f"  The start is {self.singular}")
        lines += [f"  Warning: {text}" for text in self.warnings]
        lines += [f"  Note: {text}" for text in self.notes]
        return "\n".join(lines)


def _load(kind: str) -> str:
    """Return what an equation holds, in the axes of the joint's first marker; for a point on a point, in W."""
    name, _, axes = kind.partition(" ")
    if name.startswith("Coincident"):
        return f"force along {name[-2]} of W"
    if name == "InPlane":
        return f"force along {axes}"
    if name == "Perpendicular" and len(axes) == 3:
        return f"moment about {next((x for x in 'xyz' if x not in axes), axes)}"
    return OTHERS.get(name.partition("[")[0], kind)


def described_error(system: System) -> float:
    """Return the largest residual of the constraints at the described configuration."""
    work = system.workspace()
    evaluate(system.program, system.state(), work)
    return float(np.abs(work.equations["g"]).max(initial=0.0))


def check(model: Model) -> Report:
    """Assemble a model and report mobility, dependent equations and assembly error; nothing is changed.

    Raises
    ------
    CompileError
        If the mechanism cannot be assembled, if its drives contradict each other where nothing is singular, or if a
        joint is described open by a tenth of the model's size.
    """
    told: list[str] = []
    stuck: list[CompileError] = []
    system, state = assemble_as_drawn(model, tell=told.extend, stuck=stuck)
    counts = mobility(system, state, system.workspace())
    singular = branching(system, state, system.workspace())
    if stuck and singular is None:
        raise stuck[0]
    told += [f"no motion goes on from this start, and nothing can be simulated: {error}" for error in stuck]
    if not np.all(np.isfinite(state.q)):
        raise CompileError(
            f"Model '{model.name}'",
            found="the assembled configuration is not finite",
            expected="finite coordinates",
            remedy="Look for zero lengths and coincident markers",
        )
    return Report(
        model=model,
        mobility=counts.mobility,
        gruebler=counts.gruebler,
        velocities=counts.velocities,
        equations=counts.equations,
        redundant=counts.redundant,
        assembly_error=described_error(system),
        moved=float(np.abs(state.q - system.q0).max(initial=0.0)),
        misfits=dict(system.misfits),
        indeterminate=counts.indeterminate,
        notes=(*oversights(model), *system.unlocated, *_moved_there(model, system, state)),
        warnings=(*told, *overlaps(system, state)),
        singular=singular,
        assembled=None if stuck else (system, state),
    )


def _moved_there(model: Model, system: System, state) -> list[str]:
    """Return a sentence about a drive that moved parts far from the drawing, or else about the body moved most."""
    if asked := begins_elsewhere(system, state.t):
        return [
            f"{asked}, where assembly has moved the parts: a drive prescribes the coordinate of its joint, not a way "
            "from the drawing"
        ]
    return _moved_furthest(model, system, state)


def _moved_furthest(model: Model, system: System, state) -> list[str]:
    """Return a sentence about the body that assembly moved most, if that is a good part of the model's size."""
    far, name, size = 0.0, "", system.lengths.whole
    for body in model.bodies:
        span = system.body_slices[body.name][0]
        if body.n_velocities and span.stop - span.start >= 3:
            moved = float(np.linalg.norm(state.q[span][:3] - system.q0[span][:3]))
            far, name = max((far, name), (moved, body.name))
    if far <= FAR * size:
        return []
    return [
        f"assembly moved the body '{name}' by {far:.3g} m, {far / size:.0%} of the model's size: it was described away "
        "from its joints. Look at its at=, rotation= and markers"
    ]
