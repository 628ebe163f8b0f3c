"""`JointTree`: a model in relative coordinates, the coordinates of the joints that carry its bodies."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from flexmb.errors import ModelError, did_you_mean
from flexmb.math.jets import SignalCode, sample_signals
from flexmb.math.tables import State, Work
from flexmb.model.model import Model
from flexmb.model.pose import as_pose
from flexmb.model.signal import pack
from flexmb.system import assemble_as_drawn
from flexmb.system.given_state import given_state
from flexmb.system.program import evaluate, keep_branches
from flexmb.system.system import System
from flexmb.tree.coordinates.carriers import carriers
from flexmb.tree.coordinates.centroid import Centroid, centroid
from flexmb.tree.coordinates.driven import driven_coordinates
from flexmb.tree.coordinates.joint_jacobian import write_jacobian
from flexmb.tree.coordinates.linked import invertible_links, moving_links, refuse_drives, timeless_chart
from flexmb.tree.coordinates.motions import counted_turns, describable, euler_places, labels, motion_rows
from flexmb.tree.coordinates.no_inertia import without_inertia
from flexmb.tree.coordinates.passes import read_state
from flexmb.tree.coordinates.products import mass_product, mass_solution, torques
from flexmb.tree.coordinates.reach import reach
from flexmb.tree.coordinates.relative_state import RelativeState, checked_numbers, checked_time, require_axes
from flexmb.tree.coordinates.settle import Chart, place, settle
from flexmb.tree.rigid.link_tree import LinkTree
from flexmb.tree.rigid.motion import evaluate_links
from flexmb.tree.rigid.products import invertible
from flexmb.tree.spanning import Spanning, spanning_tree

__all__ = ["JointTree"]


class JointTree:
    """The tree of a model's joints, with its relative coordinates.

    A coordinate is a turn (rad) or slide (m) of a joint as `JointCoordinate` counts it. A spherical joint has the Euler
    parameters of marker b relative to a; its rates are the relative angular velocity in axes of b. A free body has its
    position and Euler parameters; its rates are the velocities in body axes. Modal coordinates come after the
    coordinates of their body. Joints that permit no simple motion (rods, curves, couplings, rolling) and joints that
    close loops are cut. Theory: recursive.

    Parameters
    ----------
    model : Model
    cut : tuple of str
        Joints to cut; by default the choice that leaves the fewest closing equations.
    keep : tuple of str
        Joints that must carry a body.

    Raises
    ------
    CompileError
        If a joint in `keep` permits no simple motion, or closes a loop with others of them; if a joint is drawn open,
        in place or direction, as `simulate` refuses it.

    Attributes
    ----------
    system : System
    tree : Spanning
    names, rate_names : tuple of str
        "A.turn", "B.slide", "ball.ball_0", "hub.frame_0", "wing.mode_1", in the order of q and of v.
    drives : dict of str to Drive
        Coordinates that are prescribed, and by what.
    driven : dict of str to Signal
        What these coordinates are, in m or rad.

    Examples
    --------
    >>> rod = fmb.RigidBody.rod("rod", length=1.0, mass=1.0, rotation=(0, 0, 0.5))
    >>> hinge = fmb.Revolute("A", markers=("ground.origin", "rod.start"))
    >>> tree = fmb.JointTree(fmb.Model(bodies=[fmb.Ground(), rod], joints=[hinge]))
    >>> tree.names, tree.start.q.round(6).tolist()
    (('A.turn',), [0.5])
    """

    def __init__(self, model: Model, *, cut: tuple[str, ...] = (), keep: tuple[str, ...] = ()):
        self._describe(*assemble_as_drawn(model), tuple(cut), tuple(keep))

    @classmethod
    def of(cls, system: System, start: State, cut: tuple[str, ...] = ()) -> JointTree:
        """Return the tree of a compiled model, with a state that satisfies its joints as the start."""
        tree = cls.__new__(cls)
        tree._describe(system, start, cut, ())
        return tree

    def _describe(self, system: System, start: State, cut: tuple[str, ...], keep: tuple[str, ...]) -> None:
        self.model = system.model
        self.system, self._start = system, start
        count = {name: span.stop - span.start for name, span in self.system.joint_equations.items()}
        plain = {
            j.name: not j.prescribes and not j.couples and describable(j, count[j.name]) for j in self.system.joints
        }
        self.tree: Spanning = spanning_tree(self.system, cut, carriers(self.system, plain, keep))
        self.work = self.system.workspace()
        evaluate(self.system.program, self._start, self.work)
        self.rows = motion_rows(self.system, self.tree, self.work.markers, start.q)
        self.names, self.rate_names = labels(self.system, self.tree, self.rows)
        self.drives, self.driven = driven_coordinates(self.system, self.tree, self.rows, self.places)

    @cached_property
    def _driven_turns(self):
        """Places of the turns that drives prescribe, and their signals as `sample_signals` reads them."""
        turns = {name: s for name, s in self.driven.items() if not name.rpartition(".")[2].startswith("slide")}
        return (
            [self.places[name] for name in turns],
            SignalCode(*pack([s.program() for s in turns.values()])),
            np.zeros((len(turns), 3)),
        )

    @cached_property
    def places(self) -> dict[str, int]:
        """Places of the coordinates in q."""
        return {name: k for k, name in enumerate(self.names)}

    @cached_property
    def rate_places(self) -> dict[str, int]:
        """Places of the rates in v."""
        return {name: k for k, name in enumerate(self.rate_names)}

    @property
    def start(self) -> RelativeState:
        """The assembled start."""
        return self.relative(self._start)

    def index(self, name: str) -> int:
        """Return the place of a coordinate in q; ModelError if there is none of that name."""
        if name not in self.places:
            raise ModelError(
                "JointTree",
                found=f"there is no coordinate '{name}'",
                expected=f"One of: {', '.join(self.names)}",
                remedy=did_you_mean(name, self.names),
            )
        return self.places[name]

    def relative(self, state: Any) -> RelativeState:
        """Return the relative coordinates of a state or an instant of a solution (its ``t q u a``).

        Turns are counted on where the model counts them (in drives, couplers, torsion springs); elsewhere they lie in
        (-pi, pi].

        Raises
        ------
        ModelError
            If the state belongs to another model.
        """
        return self.read(given_state(state, self.system, "JointTree", reactions=False), self.work)

    def read(self, own: State, work: Work) -> RelativeState:
        """Return the relative coordinates of a state of the tree's system; the workspace is written."""
        evaluate(self.system.program, own, work)
        q, v, a = np.zeros(len(self.names)), np.zeros(len(self.rate_names)), np.zeros(len(self.rate_names))
        read_state(self.rows, own, work, q, v, a)
        near = {at: own.q[self.system.program.branches + branch] for at, branch in self.counted}
        if self.drives:
            places, signals, values = self._driven_turns
            sample_signals(own.t, signals, values)
            near.update(zip(places, values[:, 0], strict=True))
        for at, angle in near.items():
            q[at] += 2.0 * np.pi * np.round((angle - q[at]) / (2.0 * np.pi))
        return RelativeState(q, v, a, own.t)

    def absolute(self, q: Any, v: Any = None, a: Any = None, t: float = 0.0) -> State:
        """Return the state (t, q, u, a in absolute coordinates) of relative coordinates, rates and second rates.

        Parameters
        ----------
        q : (nq,) or RelativeState
        v, a : (nv,), optional
            Zero unless given.

        Raises
        ------
        ModelError
            If a vector has another length than the coordinates.
        """
        if isinstance(q, RelativeState):
            q, v, a, t = q.q, q.v, q.a, q.t
        q, v, a = self._checked(q, v, a)
        program, work = self.system.program, self.work
        state = self.system.state(checked_time(t))
        settle(self.rows, program, work, self._start.q, q, v, a, state)
        for at, branch in self.counted:
            state.q[program.branches + branch] = q[at]
        if self.system.branch_names:
            work.weights[0].wanted = 0
            evaluate(program, state, work)
            keep_branches(program, work, state.q)
        return state

    def pose(self, marker: str, q: Any) -> tuple[np.ndarray, np.ndarray]:
        """Return position (3,), m, and axes (3, 3) in W of a marker at relative coordinates q (nq,)."""
        number = self._marker(marker)
        self._placed(q)
        seen = self.work.markers[number]
        return seen["r"].copy(), seen["R"].copy()

    def jacobian(self, marker: str, q: Any) -> np.ndarray:
        """Return the twist of a marker per rate, (6, nv): velocity (m/s) and angular velocity (rad/s) in W, at its
        origin.

        Source: Whitney 1972 for joints; modes by eq. (tree-jacobian).
        """
        number = self._marker(marker)
        self._placed(q)
        body = self._bodies[marker.partition(".")[0]] if self.work.markers[number]["nu"] else -1
        out = np.zeros((6, len(self.rate_names)))
        write_jacobian(self.rows, self.tree.tables.parent, self.work, body, number, out)
        return out

    def marker_acceleration(self, marker: str, q: Any, v: Any, a: Any = None, t: float = 0.0) -> np.ndarray:
        """Return acceleration (m/s2) and angular acceleration (rad/s2) of a marker in W, (6,), at its origin.

        J a + J' v with the Jacobian J: without second rates a (nv,), what the rates v (nv,) alone give.
        """
        number = self._marker(marker)
        state = self.absolute(q, v, a, t)
        seen, J = self.work.markers[number], self.work.J
        nu, at, iu = int(seen["nu"]), int(seen["iJ"]), int(seen["iu"])
        return J[at : at + 6 * nu].reshape(6, nu) @ state.a[iu : iu + nu] + seen["bias"]

    def centroid(self, q: Any, v: Any = None, a: Any = None) -> Centroid:
        """Return the centre of mass of all bodies and their momenta, with Jacobians and rates, eq. (tree-centroid).

        Rates v and second rates a (nv,) are zero unless given: the acceleration at v alone is J' v.
        """
        if isinstance(q, RelativeState):
            q, v, a = q.q, q.v, q.a
        q, v, a = self._checked(q, v, a)
        return centroid(self, self.absolute(q, v, a), v)

    @cached_property
    def _bodies(self) -> dict[str, int]:
        """Places of the bodies in the order of the tree."""
        return {name: k for k, name in enumerate(self.tree.order)}

    def torques(self, q: Any, v: Any = None, a: Any = None, t: float = 0.0) -> np.ndarray:
        """Return the forces (nv,) on the rates that a motion needs in addition to the model's (N m, N, modal forces).

        Recursive inverse dynamics (Luh, Walker & Paul 1980), here with flexible bodies: two passes over the links, eq.
        (link-torques); trees with cables, beams or plates take the equations of all bodies, eq.
        (tree-torques). Drives count as what supplies the torque.

        Raises
        ------
        CompileError
            If loops are closed by cut joints: their forces are not determined by the motion of the tree. If a force
            depends on reactions, as friction of joints does.
        """
        if isinstance(q, RelativeState):
            q, v, a, t = q.q, q.v, q.a, q.t
        q, v, a = self._checked(q, v, a)
        return torques(self, q, v, a, checked_time(t))

    def accelerations(self, q: Any, v: Any = None, tau: Any = None, t: float = 0.0) -> np.ndarray:
        """Return the second rates (nv,) under the forces of the model and of joints: forward dynamics.

        The articulated-body algorithm in link axes (Featherstone 2008, table 7.1), of flexible bodies with their modes
        eliminated body by body (Banerjee 1993), with closed loops. `Recursive` also gives reactions.

        Parameters
        ----------
        q, v : (nq,), (nv,)
            Where loops are closed, coordinates that close them.
        tau : (nv,), N m or N, optional
            Forces on the joints and modes, as in `torques`.

        Raises
        ------
        CompileError
            If the model has more than points, rigid and reduced bodies, and forces of place and motion, with states or
            without, or a motion has no inertia.
        """
        if isinstance(q, RelativeState):
            q, v, t = q.q, q.v, q.t
        q, v, tau = self._checked(q, v, tau)
        links = self._moved_links()
        links.x[:], links.v[:], links.tau[:] = q, v, tau
        evaluate_links(links, self.work, checked_time(t))
        if links.run[0].failed >= 0:
            raise without_inertia(self.tree, links, self.model)
        return links.a.copy()

    def bias(self, q: Any, v: Any = None, t: float = 0.0) -> np.ndarray:
        """Return the forces (nv,) that keep the rates v, zero unless given: of velocities, weight, springs, modes;
        `torques` at a = 0.
        """
        if isinstance(q, RelativeState):
            q, v, t = q.q, q.v, q.t
        return self.torques(q, v, None, t)

    def mass_product(self, q: Any, a: Any) -> np.ndarray:
        """Return M(q) a (nv,) of second rates (nv,), in linear time; with what accelerations stiffen at bent bodies.

        Raises
        ------
        CompileError
            If loops are closed by cut joints.
        """
        return mass_product(self, *self._checked(q, None, a)[::2])

    def mass_solution(self, q: Any, tau: Any) -> np.ndarray:
        """Return M(q)^-1 tau (nv,) of forces on the rates (nv,), in linear time; with loops, the motion they allow.

        Raises
        ------
        CompileError
            As in `accelerations`.
        """
        return mass_solution(self, self._moved_links(), *self._checked(q, None, tau)[::2])

    def _moved_links(self) -> LinkTree:
        refuse_drives(self)  # forward dynamics is for joints that forces move
        return self._links

    def linked(self, chart: Chart) -> LinkTree:
        """Return the links of the model, with its forces and cut joints.

        Raises
        ------
        CompileError
            If the model has more than points, rigid and reduced bodies, and forces of place and motion, with states or
            without, or a motion has no inertia.
        """
        return moving_links(self, chart, self._start)

    @cached_property
    def invertible_links(self) -> LinkTree | None:
        """The links for inverse dynamics, which need not have inertia; None if the model has more than they know."""
        return invertible(self._links) if "_links" in vars(self) else invertible_links(self, self._start)

    @cached_property
    def _links(self) -> LinkTree:
        return self.linked(timeless_chart(self, self._start))

    def reach(
        self,
        marker: str,
        at: Any,
        *,
        start: Any = None,
        limits: Mapping[str, tuple[float, float]] | None = None,
        orientation: bool = True,
        tolerance: float = 1e-10,
    ) -> np.ndarray:
        """Return relative coordinates (nq,) that bring a marker to a pose: inverse kinematics by damped least squares.

        Parameters
        ----------
        marker : str
        at : Pose or (3,), m
            The pose to reach, in W.
        start : (nq,), optional
            Where the search begins; the assembled start unless given. Modes, driven and free coordinates stay there.
        limits : dict of coordinate name to (low, high), rad or m, optional
        orientation : bool
            Let the axes agree as well.
        tolerance : float, m
            Largest distance, with the angle times the largest lever.

        Raises
        ------
        ModelError
            If the pose is out of reach, with the nearest distance found; if no joint moves the marker.
        """
        begin = self.start.q if start is None else self._checked(start, None, None)[0]
        return reach(self, marker, as_pose(at, "JointTree", "at"), begin, limits or {}, orientation, tolerance)

    def _marker(self, name: str) -> int:
        self.model.marker(name, "JointTree")
        return self.system.marker_index[name]

    def _placed(self, q: Any) -> State:
        """Return the state at relative coordinates without velocity, and leave its kinematics in the workspace."""
        state = self.system.state()
        place(self.rows, self.system.program, self.work, self._start.q, self._checked(q, None, None)[0], state)
        return state

    def _checked(self, q, v, a):
        q = q.q if isinstance(q, RelativeState) else q
        numbers = checked_numbers({"q": (q, self.names), "v": (v, self.rate_names), "a or tau": (a, self.rate_names)})
        require_axes(numbers[0], self._euler, self.names)
        return numbers

    @cached_property
    def _euler(self) -> np.ndarray:
        return euler_places(self.rows)

    @cached_property
    def counted(self) -> tuple[tuple[int, int], ...]:
        """Turns that the model counts: (place in q, number of the branch)."""
        return counted_turns(self.system, self.rows)
