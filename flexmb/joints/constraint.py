"""`Constraint`: an equation of your own between measured quantities."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, ClassVar

from flexmb.constraints import Formula, Measured
from flexmb.constraints.measured_kernels import POSITION, VELOCITY
from flexmb.errors import ModelError, did_you_mean
from flexmb.math import operations as op
from flexmb.model.described import check_mapping, is_number
from flexmb.model.equation_text import Input, read_equation
from flexmb.model.expression import SignalProgram
from flexmb.model.foreign import imported
from flexmb.model.kinds import Joint, Sensor
from flexmb.model.part import Part
from flexmb.model.sensor_columns import found_in
from flexmb.model.signal import Signal

__all__ = ["Constraint"]

LEVELS = ("position", "velocity")
KINKS = {op.ABS: "abs", op.SIGN: "sign", op.STEP: "step", op.MIN: "min", op.MAX: "max", op.WHERE: "where"}


@dataclass(frozen=True, eq=False)
class Constraint(Joint):
    """Let measured quantities satisfy an equation, eq. (formula).

    An equation between positions is holonomic; one that has velocities or rates is non-holonomic, linear in them or
    not: it restricts velocities (where it can be integrated, positions stay where they are). Both may depend on time.
    All derivatives are exact. The constraint is ideal: its force is the multiplier times the gradient of the equation
    (by velocities, where it has them; Chetaev), so it does work only where the equation moves by itself. Add what else
    the contact gives in `forces`: it is C of Udwadia's equation of motion for non-ideal constraints.

    Parameters
    ----------
    name : str
    over : list of sensors or names of sensors, or mapping of names in the equation to them
        What the equation reads: `Position`, `Velocity`, `AngularVelocity`, `Distance`, `JointCoordinate`,
        `AxisCosine`. Components are ``p[0]``, ``p[1]``, ``p[2]``; ``{"x": "bob place x"}`` names one of a sensor.
    equation : str
        Residual, ``"p[0]**2 + p[1]**2 - L**2"``, or both sides with ``=``. ``rate(x)`` is the rate of a position, ``t``
        the time. Functions and numbers as in expressions; functions with a kink are refused.
    level : "position" or "velocity", optional
        By default velocity if the equation reads a velocity or a rate.
    parameters : mapping of name to number or function of time
        What other names in `equation` and `forces` stand for.
    function : callable, or "module:function" in model files, which is imported only if the file is trusted
        Residual in the place of `equation`: ``function(t, x)`` of the positions that `over` measures, (n,) in order; at
        the level "velocity" ``function(t, x, v)`` with their rates, then the velocities that `over` measures. Plain
        Python, or compiled by numba. It depends on its arguments only, and takes complex numbers unless a `jacobian` is
        given; a complex t is better even then. Some 100 us for each evaluation.
    jacobian : callable, or "module:function", optional
        Derivatives (n,) by x, then v, with the same arguments.
    forces : mapping of quantity to str, optional
        Forces that the constraint exerts beside its ideal one, on measured quantities: ``{"v[0]": "-c*v[0]"}`` pushes
        along v[0], N or N m. They are given, do not depend on the multiplier, and count as loads.
    """

    _: KW_ONLY
    over: Any
    equation: str | None = None
    level: str | None = None
    parameters: Mapping[str, Any] = field(default_factory=dict)
    forces: Mapping[str, str] = field(default_factory=dict)
    function: Any = None
    jacobian: Any = None
    markers: tuple[str, str] = ("", "")

    imports: ClassVar[tuple[str, ...]] = ("function", "jacobian")
    couples: ClassVar[bool] = True
    works: ClassVar[bool] = True

    def __post_init__(self):
        Part.__post_init__(self)
        object.__setattr__(self, "over", self._named(self.over))
        for name in ("parameters", "forces"):
            check_mapping(getattr(self, name), self.title, name, '{"L": 0.5}')
        for name, value in self.parameters.items():
            if not is_number(value) and not isinstance(value, Signal):
                raise ModelError(
                    self.title,
                    found=f"the parameter {name} = {value!r}",
                    expected="a finite number or a signal",
                    remedy=f"Give {name} a number, or fmb.table(...), fmb.expression(...)",
                )
        object.__setattr__(self, "_callbacks", [])
        self._check_function()
        texts = {} if self.equation is None else {"equation": self.equation}
        for what, text in {**texts, **self.forces}.items():
            if not isinstance(text, str) or not text.strip():
                raise ModelError(
                    self.title,
                    found=f"{what} = {text!r}",
                    expected="a text",
                    remedy='Write equation="p[0]**2 + p[1]**2 - L**2"',
                )
        if self.level not in (*LEVELS, None):
            raise ModelError(
                self.title,
                found=f"level = {self.level!r}",
                expected="'position', 'velocity' or nothing",
                remedy=did_you_mean(str(self.level), LEVELS) or "Leave level away: it follows from the equation",
            )

    def _check_function(self) -> None:
        """Raise ModelError unless there is one of equation and function, and functions are callable or named."""
        if (self.equation is None) == (self.function is None):
            raise ModelError(
                self.title,
                found="neither equation nor function" if self.equation is None else "both equation and function",
                expected="one of them",
                remedy='Write equation="p[0]**2 + p[1]**2 - L**2", or function=lambda t, x: ...',
            )
        for name in ("function", "jacobian"):
            value = getattr(self, name)
            if value is not None and not callable(value) and not (isinstance(value, str) and value.count(":") == 1):
                raise ModelError(
                    self.title,
                    found=f"{name} = {value!r}",
                    expected="a function (t, x), or (t, x, v) at the level 'velocity', or 'module:function'",
                    remedy=f"Write {name}=lambda t, x: ...",
                )

    def complaint(self) -> str:
        """Return what went wrong in the function, if anything did."""
        return next((c.failure for c in self._callbacks if c.failure), "")  # type: ignore[attr-defined]

    def _named(self, over: Any) -> dict[str, Any]:
        """Return the measured quantities by their names in the equation."""
        if isinstance(over, str | Sensor):
            over = (over,)
        if isinstance(over, Mapping):
            named = dict(over)
        elif isinstance(over, list | tuple) and all(isinstance(given, str | Sensor) for given in over):
            named = {given.name if isinstance(given, Sensor) else given: given for given in over}
        else:
            named = {"": over}
        for name, given in named.items():
            if not isinstance(given, str | Sensor) or not isinstance(name, str) or not name.isidentifier():
                raise ModelError(
                    self.title,
                    found=f"over holds {name!r}: {given!r:.60}"
                    if isinstance(name, str)
                    else f"over holds {name!r:.60}",
                    expected="sensors whose names are words of letters, digits and _, or such names",
                    remedy='Write over=[fmb.Position("p", marker="bob.center")], or over={"p": "name of a sensor"}',
                )
        if not named or (not isinstance(over, Mapping) and len(named) < len(over)):
            raise ModelError(
                self.title,
                found=f"over = {list(named)}",
                expected="at least one measured quantity, each once",
                remedy='Write over=[fmb.Position("p", marker="bob.center")]',
            )
        return named

    def check(self, model) -> None:
        """Raise ModelError if a name is unknown, or the equation does not fit its level."""
        self._formula(model)

    def sensors(self, model) -> dict[str, Sensor]:
        """Return the sensors by their names in the equation."""
        return {name: sensor for name, (sensor, _) in self._read(model).items()}

    def _read(self, model) -> dict[str, tuple[Sensor, int | None]]:
        """Return the sensors by their names in the equation, and the number of the column where one is named."""
        found: dict[str, tuple[Sensor, int | None]] = {}
        for name, given in self.over.items():
            if isinstance(given, Sensor):
                given.check(model)
                found[name] = (given, None)
                continue
            named = found_in(model, given)
            if named is None:
                known = [sensor.name for sensor in model.sensors]
                raise ModelError(
                    self.title,
                    found=f"sensor '{given}' does not exist",
                    expected=f"The model has: {', '.join(known) or 'no sensors'}",
                    remedy=did_you_mean(given, known) or "Add the sensor to the model, or give the sensor itself",
                )
            found[name] = named
        return found

    def _measured(self, model) -> dict[str, tuple[Measured, ...]]:
        """Return what is measured, by the names in the equation."""
        found = {}
        for name, (sensor, column) in self._read(model).items():
            scalars = sensor.measured(model)
            found[name] = scalars if column is None else scalars[column : column + 1]
        return found

    def resolved_markers(self, model) -> tuple[str, ...]:
        """Return the markers of all that the equation reads, each once; one alone twice."""
        read = self._formula(model).inputs
        names = tuple(dict.fromkeys(marker for scalar in read for marker in scalar.markers))
        return names if len(names) > 1 else names * 2

    def equations_in(self, model):
        """Return the one equation."""
        return (self._formula(model),)

    def places(self, model) -> tuple[str, ...]:
        """Return the markers whose coordinates in W the equation reads."""
        return tuple(z.markers[0] for z in self._formula(model).inputs if z.what == "place")

    def in_world_axes(self, model) -> str | None:
        """Return the name of a quantity that is a component in the axes of W, or None."""
        measured = self._measured(model)
        alone = ("place", "velocity", "spin")
        return next(
            (n for n, scalars in measured.items() for z in scalars if z.what in alone and len(z.markers) == 1), None
        )

    def _formula(self, model) -> Formula:
        measured = self._measured(model)
        sizes = {name: len(scalars) for name, scalars in measured.items()}
        read: list[Input] = []
        if self.function is not None:
            return self._of_function(measured)
        program = read_equation(str(self.equation), sizes, self.parameters, read, self.title)
        of_equation = len(read)
        given = self._given(sizes, read)
        scalars = tuple(self._scalar(one, measured) for one in read)
        self._require_smooth(program)
        level = self._level(scalars[:of_equation])
        if level == 0:
            self._require_two_derivatives(read[:of_equation])
        return Formula(scalars, program, level, given)

    def _of_function(self, measured: Mapping[str, tuple[Measured, ...]]) -> Formula:
        """Return the equation of the function: positions, then their rates and velocities, then what forces read."""
        every = [z for scalars in measured.values() for z in scalars]
        for name, scalars in measured.items():
            if any(z.alone for z in scalars):
                raise self._of_states(name)
        positions = [z for z in every if z.sort == POSITION]
        level = int(self.level == "velocity")
        moving = [z.of_rate() for z in positions] + [z for z in every if z.sort == VELOCITY]
        if not level and len(positions) < len(every):
            raise ModelError(
                self.title,
                found="a function of velocities at the level 'position'",
                expected="level='velocity' for a function (t, x, v)",
                remedy="Give level='velocity', or leave the velocities out of over",
            )
        if self.forces:
            raise ModelError(
                self.title,
                found="forces beside a function",
                expected="forces beside an equation",
                remedy="Write the constraint as an equation, or add a force of its own",
            )
        function, jacobian = (None if f is None else imported(f, self.title) for f in (self.function, self.jacobian))
        return Formula(
            tuple(positions + moving if level else positions),
            SignalProgram.of(),
            level,
            function=function,
            jacobian=jacobian,
            keep=self._callbacks,  # type: ignore[attr-defined]
        )

    def _given(self, sizes: Mapping[str, int], read: list[Input]) -> tuple[tuple[int, SignalProgram], ...]:
        """Return the given forces: on which of the inputs, and their programs."""
        given = []
        for quantity, text in self.forces.items():
            pushed = read_equation(quantity, sizes, {}, read, self.title)
            if list(pushed.ops) != [op.INPUT] or read[int(pushed.args[0])].signal is not None:
                raise ModelError(
                    self.title,
                    found=f"forces on '{quantity}'",
                    expected=f"forces on measured quantities: {', '.join(sizes)}, or components of them",
                    remedy='Write forces={"v[0]": "-c*v[0]"}',
                )
            given.append((int(pushed.args[0]), read_equation(text, sizes, self.parameters, read, self.title)))
        return tuple(given)

    def _scalar(self, one: Input, measured: Mapping[str, tuple[Measured, ...]]) -> Measured:
        if one.signal is not None:
            return Measured("signal", signal=one.signal, rate=one.rate)
        scalar = measured[one.name][one.column]
        if scalar.alone:
            raise self._of_states(one.name)
        if one.rate and scalar.sort != POSITION:
            raise ModelError(
                self.title,
                found=f"rate({one.name}), an acceleration",
                expected="equations between positions and velocities",
                remedy=f"Integrate the equation once: it then restricts {one.name} itself",
            )
        return scalar.of_rate() if one.rate else scalar

    def _of_states(self, name: str) -> ModelError:
        return ModelError(
            self.title,
            found=f"'{name}', whose rates depend on forces",
            expected="positions and velocities of bodies",
            remedy="Let a force or an actuator follow it, or restrict places, joint coordinates and velocities",
        )

    def _require_two_derivatives(self, read: list[Input]) -> None:
        """Raise ModelError for the rate of a signal in an equation of positions: accelerations need its third one."""
        rates = [one.name for one in read if one.signal is not None and one.rate]
        if rates:
            raise ModelError(
                self.title,
                found=f"rate({rates[0]}) of a signal in '{self.equation}', which restricts positions",
                expected="quantities with two derivatives by time: of a signal only two are known, of its rate one",
                remedy="Give the rate a signal of its own, fmb.expression(...) or fmb.table(...), or write it out in t",
            )

    def watched(self, model) -> tuple[tuple[Measured, ...], tuple[SignalProgram, ...]]:
        """Return what its given forces read, and their programs: steps end where these have kinks."""
        if not self.forces:
            return (), ()
        formula = self._formula(model)
        return formula.inputs, tuple(program for _, program in formula.given)

    def _require_smooth(self, program: SignalProgram) -> None:
        """Raise ModelError for functions of measured quantities that have no second derivative everywhere."""
        kinks = [KINKS[int(code)] for code in program.ops if int(code) in KINKS]
        if kinks:
            raise ModelError(
                self.title,
                found=f"'{kinks[0]}' of a measured quantity in '{self.equation}': it has no derivative everywhere",
                expected="an equation with two derivatives: the motion would jump at the kink",
                remedy="Use smooth functions (x**2, sqrt, tanh, smooth); of t alone, kinks are allowed",
            )

    def _level(self, scalars: tuple[Measured, ...]) -> int:
        """Return 0 for an equation between positions, 1 for one with velocities."""
        sorts = {scalar.sort for scalar in scalars}
        moving = VELOCITY in sorts
        if not sorts & {POSITION, VELOCITY}:
            raise ModelError(
                self.title,
                found=f"'{self.equation}' reads no measured quantity",
                expected=f"an equation in {', '.join(self.over)}",
                remedy="Name what it restricts: p[0], rate(phi)",
            )
        if self.level is not None and (self.level == "velocity") != moving:
            raise ModelError(
                self.title,
                found=f"level = '{self.level}', and the equation reads {'velocities' if moving else 'no velocity'}",
                expected="positions only, or at least one velocity or rate at the level 'velocity'",
                remedy="Leave level away"
                if moving
                else "Write rate(...) of the quantity to restrict, or leave level away",
            )
        return int(moving)
