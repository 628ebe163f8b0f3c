"""What is measured while the motion is computed, and what follows it: names become one row of programs.

Signals that follow measurements are taken apart: what depends on time alone is a signal of its own, a column of a
sensor is an atom, a block brings its states, and everything else is a program that reads these and programs before it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmb.constraints import Measured
from flexmb.constraints.loop import LOOP, LOOP_TANGENT
from flexmb.constraints.measured import Projected
from flexmb.constraints.measured_kernels import ACCELERATION, POSITION, REACTION
from flexmb.errors import ModelError
from flexmb.math import operations as op
from flexmb.math.switches import KINK
from flexmb.model.block import Block, OwnState
from flexmb.model.expression import SignalProgram
from flexmb.model.function_block import Function
from flexmb.model.held_block import HeldBlock, HeldValue
from flexmb.model.measurement import Formula, Measurement, input_program
from flexmb.model.sensor_columns import found_in, not_found_in
from flexmb.model.signal import Constant, Signal
from flexmb.system.holds import HELD, NEVER, Hold
from flexmb.system.loop_kinks import Kink, kinks_in, located
from flexmb.system.loop_places import LoopPlaces
from flexmb.system.loop_programs import LATER, inputs_of, with_inputs
from flexmb.system.loop_row import loop_row
from flexmb.system.wrenches import Wrenches

__all__ = ["Loops"]


class Loops:
    """Collects what follows measurements while the parts of a model write themselves."""

    def __init__(self, compiler):
        self.compiler = compiler
        self.atoms: list[Measured] = []
        self._atom_numbers: dict[Measured, int] = {}
        self.programs: list[SignalProgram] = []
        self.addresses: list[int] = []
        self.outputs: list[tuple[int, int]] = []
        self.rates: list[tuple[int, int, int]] = []
        self.channels: list[tuple[int, int]] = []
        self.kept: list[Any] = []
        self._known: dict[int, SignalProgram] = {}
        self._open: dict[int, str] = {}
        self._numbers: dict[int, int] = {}
        self._slot_of: dict[int, int] = {}
        self._slots: dict[tuple, int] = {}
        self._blocks: dict[int, tuple[str, tuple[str, ...]]] = {}
        self._waiting: list[tuple[Block, str]] = []
        self._held: dict[int, str] = {}
        self._unread: list[tuple[HeldBlock, str]] = []
        self._writers: list[str] = []
        self.holds: list[Hold] = []
        self.kinks: list[tuple[int, Kink, str]] = []
        self.unlocated: list[str] = []
        self._watched: set[int] = set()
        self.wrenches = Wrenches(compiler)
        self.n_channels = 0
        self.places: LoopPlaces | None = None
        self.size = 0  # numbers that are kept of an evaluation, behind the Jacobians

    def follow(self, signal: Signal, markers: tuple[int, ...]) -> tuple[int, tuple[int, ...]]:
        """Return the number of a signal, and the channels by which forces on markers change with it (-1: by none)."""
        if not signal.follows:
            return self.compiler.signal(signal), (-1,) * len(markers)
        if id(signal) not in self._numbers:
            slot = self._slot(self._program(signal))
            number = self.compiler.signal(Constant(0.0))  # its value is written by the loop
            self._numbers[id(signal)] = number
            self.outputs.append((slot, number))
            self._slot_of[number] = slot
            self.kept.append(signal)
        number = self._numbers[id(signal)]
        slot = self._slot_of[number]
        first = len(self.channels)
        self.channels += [(slot, marker) for marker in markers]
        return number, tuple(range(first, len(self.channels)))

    def watch(self, scalars: tuple[Measured, ...], programs: tuple[SignalProgram, ...]) -> None:
        """Let steps end where forces that others compute of measured scalars have kinks or jump."""
        for program in programs:
            if any(True for _ in kinks_in(program, lambda _: True)):
                read = {k: self._atom(scalars[k]) for k in inputs_of(program)}
                whole = with_inputs(program, [read.get(k, input_program(0)) for k in range(len(scalars))])
                self._watched.add(self._slot(whole))

    def _slot(self, program: SignalProgram, address: int = 0) -> int:
        """Return the number of the result of a program; what is computed alike is computed once."""
        if address == 0 and list(program.ops) == [op.INPUT] and program.args[0] >= LATER:
            return int(program.args[0]) - LATER
        tables = (id(table) for table in program.tables)
        same = address, program.inputs, program.ops.tobytes(), program.args.tobytes(), *tables
        known = self._slots.setdefault(same, len(self.programs))
        if known == len(self.programs):
            self.programs.append(program)
            self.addresses.append(address)
            self._writers.append(self.compiler.writing)
        return known

    def _atom(self, scalar: Measured | Projected) -> SignalProgram:
        """Return the program that reads a measured scalar."""
        if isinstance(scalar, Projected):
            times, plus = SignalProgram.of((op.MULTIPLY, 0.0)), SignalProgram.of((op.ADD, 0.0))
            terms = [self._atom(a).then(self._atom(b), times) for a, b in scalar.products]
            return terms[0].then(terms[1], plus, terms[2], plus)
        known = self._atom_numbers.setdefault(scalar, len(self.atoms))
        if known == len(self.atoms):
            self.atoms.append(scalar)
        return input_program(known)

    def _program(self, signal: Signal) -> SignalProgram:
        """Return the program of a signal, in atoms and in the results of programs."""
        if isinstance(signal, Constant):
            return signal.program()
        if id(signal) in self._known:
            return self._known[id(signal)]
        self.kept.append(signal)
        self._enter(signal, _called(signal))
        program = self._made(signal)
        if len(program.ops) > 1:
            program = input_program(LATER + self._slot(program))
        del self._open[id(signal)]
        self._known[id(signal)] = program
        return program

    def _enter(self, thing: Any, called: str) -> None:
        """Note that a signal, or a sensor that names one, is being followed; raise ModelError if it already is."""
        if id(thing) in self._open:
            names = [*self._open.values()]
            chain = " -> ".join(names[list(self._open).index(id(thing)) :])
            raise ModelError(
                self.compiler.writing,
                found=f"an algebraic loop: {chain} -> {called}",
                expected="signals that depend on each other by way of a state",
                remedy="Put a lag, an integrator or a delay into the loop",
            )
        self._open[id(thing)] = called

    def _made(self, signal: Signal) -> SignalProgram:
        if not signal.follows:
            return self._atom(Measured("signal", signal=signal))
        if isinstance(signal, Measurement):
            return self._measurement(signal.of, signal.column, signal.rate)
        if isinstance(signal, Formula):
            return self._formula(signal)
        if isinstance(signal, OwnState):
            owner, _ = self._states(signal.block)
            return self._atom(Measured("state", state=(owner, signal.name)))
        if isinstance(signal, Function):
            return self._function(signal)
        if isinstance(signal, HeldValue):
            owner = self._hold(signal.block)
            return self._atom(Measured("held", held=self.compiler.branch(f"{HELD}{owner}: {signal.name}")))
        if isinstance(signal, HeldBlock):
            self._hold(signal)
            return self._program(signal.output())
        if isinstance(signal, Block):
            self._states(signal)
            return self._program(signal.output())
        return signal.program_of([self._program(part) for part in signal.parts()])

    def _function(self, function: Function) -> SignalProgram:
        """Return what reads the result of a function of the user; every argument is a program of its own."""
        arguments = []
        for part in function.of:
            own = self._program(part)
            if list(own.ops) != [op.INPUT] or own.args[0] in arguments:
                own = input_program(
                    LATER + self._slot(own.then(SignalProgram.of((op.CONSTANT, 1.0), (op.MULTIPLY, 0.0))))
                )
            arguments.append(own.args[0])
        read = SignalProgram.of(*((op.INPUT, argument) for argument in arguments))
        return input_program(LATER + self._slot(read, function.address()))

    def _states(self, block: Block) -> tuple[str, tuple[str, ...]]:
        """Return owner and names of the states of a block, which are registered when it is first met."""
        if id(block) not in self._blocks:
            states = block.states()
            owner, title = self._owner(block)
            if states:
                self.compiler.state_marker(title, states, block.sizes())
                self._waiting.append((block, title))
            self._blocks[id(block)] = owner, tuple(states)
            self.kept.append(block)
        return self._blocks[id(block)]

    def _owner(self, block: Block) -> tuple[str, str]:
        """Return how the states of a block are called, and its title."""
        # named by its part: states are carried over events by name, after which other parts may be gone
        part = self.compiler.writing.partition(" ")[2].strip("'")
        usual = [f"{block.word} of {part}", *(f"{block.word} {k} of {part}" for k in range(2, 1000))]
        known = {*self.compiler.states, *self._held.values()}
        owner = block.name or next(name for name in usual if f"Block '{name}'" not in known)
        title = f"Block '{owner}'"
        if title in known:
            raise ModelError(
                title, found="the name is used twice", expected="one block of each name", remedy="Rename one"
            )
        return owner, title

    def _hold(self, block: HeldBlock) -> str:
        """Return the title of a block that holds values, for which there is room when it is first met."""
        if id(block) not in self._held:
            _, title = self._owner(block)
            self._held[id(block)] = title
            for name, start in block.held().items():
                self.compiler.branch(f"{HELD}{title}: {name}", start)
            self._unread.append((block, self.compiler.writing))
            self.kept.append(block)
        return self._held[id(block)]

    def _read(self, block: HeldBlock) -> None:
        """Compile what a block that holds values reads."""
        title = self._held[id(block)]
        branches = tuple(self.compiler.branch(f"{HELD}{title}: {name}") for name in block.held())
        clock = -1 if block.period is None else self.compiler.branch(f"{HELD}{title}: clock", NEVER)
        passes = block.crossing()
        reads = tuple(self.follow(signal, ())[0] for signal in block.reads())
        crossing = -1 if passes is None else self.follow(passes, ())[0]
        if passes is not None:
            slot = self._slot_of[crossing]
            self.kinks.append((slot, Kink(-int(KINK), self.programs[slot]), title))
        self.holds.append(Hold(title, block, branches, reads, crossing, clock, block.period or 1.0, block.offset))

    def clocks(self) -> tuple[tuple[float, float], ...]:
        """Return period and offset of the blocks that sample, each pair once."""
        return tuple(dict.fromkeys((hold.period, hold.offset) for hold in self.holds if hold.clock >= 0))

    def _sensor(self, given: Any) -> tuple[Any, int | None]:
        """Return a sensor that is given, or the model's sensor of this name, and the column if the name says one."""
        model = self.compiler.model
        if not isinstance(given, str):
            given.check(model)
            return given, None
        found = found_in(model, given)
        if found is None:
            said = not_found_in(model, given)
            raise ModelError(
                self.compiler.writing,
                found=said.found,
                expected=said.expected,
                remedy=said.remedy or "Add the sensor to the model, or give the sensor itself",
            )
        return found

    def _measurement(self, given: Any, column: int, rate: bool) -> SignalProgram:
        sensor, own = self._sensor(given)
        if own is not None and column > 0:
            raise ModelError(
                self.compiler.writing,
                found=f"column {column} of '{given}', which is one column",
                expected="the name of a sensor and a number, or the name of a column",
                remedy=f"Leave the number out, or name {sensor.title}",
            )
        column = column if own is None else own
        signal = sensor.signal()
        if signal is not None and not rate:
            return self._program(signal)
        scalars = sensor.measured(self.compiler.model)
        if column >= len(scalars):
            raise ModelError(
                self.compiler.writing,
                found=f"column {column} of {sensor.title}",
                expected=f"columns 0 to {len(scalars) - 1}",
                remedy="Count from 0",
            )
        scalar = scalars[column]
        if rate and (scalar.sort != POSITION or isinstance(scalar, Projected)):
            raise ModelError(
                self.compiler.writing,
                found=f"the rate of {sensor.title}, which depends on forces",
                expected="rates of positions: joint coordinates, distances, positions of markers",
                remedy="Measure the velocity itself, or filter it by a lag",
            )
        return self._atom(scalar.of_rate() if rate else scalar)

    def _named(self, given: Any, column: int, rate: bool) -> SignalProgram:
        """Return what a formula reads of a sensor: a loop is told by the sensors that it passes."""
        sensor, _ = self._sensor(given)
        self._enter(sensor, f"sensor '{sensor.name}'")
        program = self._measurement(given, column, rate)
        del self._open[id(sensor)]
        return program

    def _formula(self, formula: Formula) -> SignalProgram:
        sizes = {}
        for name, given in formula.over.items():
            if not isinstance(given, Signal):
                sensor, own = self._sensor(given)
                single = own is not None or sensor.signal() is not None
                sizes[name] = 1 if single else len(sensor.measured(self.compiler.model))
        program, inputs = formula.read(sizes)
        read = []
        for one in inputs:
            if one.signal is None:
                read.append(self._named(formula.over[one.name], one.column, one.rate))
            elif not one.rate:
                read.append(self._program(one.signal))
            elif isinstance(one.signal, Measurement):
                read.append(self._measurement(one.signal.of, one.signal.column, True))
            elif not one.signal.follows:
                read.append(self._atom(Measured("signal", signal=one.signal, rate=True)))
            else:
                raise ModelError(
                    self.compiler.writing,
                    found=f"rate({one.name}) of a signal that follows measurements",
                    expected="rates of measured positions and of functions of time",
                    remedy="Use a lag, whose rate is known, or measure the rate",
                )
        return with_inputs(program, read)

    def rows(self) -> tuple[list[tuple[Any, tuple]], list[tuple[Any, tuple]]]:
        """Return the rows that run before all forces, and after them; none if nothing follows measurements."""
        while self._waiting or self._unread:
            if self._waiting:
                block, title = self._waiting.pop(0)
                first = self.compiler.states[title].marker
                for k, rate in enumerate(block.rates()):
                    slot = self._slot(self._program(rate))
                    self.rates.append((slot, first + k // 6, k % 6))
            else:
                held, self.compiler.writing = self._unread.pop(0)
                self._read(held)
        used = len(self.programs)
        self._locate()
        self.n_channels = len(self.channels)
        if not self.programs:
            return [], []
        forces = dict.fromkeys(atom.part for atom in self.atoms if atom.what == "wrench")
        wrenches, self.n_channels = self.wrenches.rows(forces, self.n_channels)
        row = loop_row(self, used)
        self.size = row["size"]
        return [*wrenches, (LOOP, LOOP.filled(None, row))], [(LOOP_TANGENT, LOOP_TANGENT.filled(None, row))]

    def find_places(self, markers: np.ndarray, tables: dict[str, np.ndarray]) -> int:
        """Find where what follows goes in the iteration matrix; return how many pairs of markers kernels need."""
        if self.places is None:
            return len(tables["pairs"])
        return self.places.found(markers, tables["pairs"], tables["pair_rows"])

    def _locate(self) -> None:
        """Let steps end where what acts on forces and states has kinks or jumps."""
        acting = {slot for slot, *_ in (*self.rates, *self.channels)} | self._watched
        varying = [atom.what != "held" for atom in self.atoms]
        bending = [atom.sort == ACCELERATION for atom in self.atoms]
        found, self.unlocated = located(self.programs, self.addresses, self._writers, varying, bending, acting)
        self.kinks += [(self._slot(kink.program), kink, title) for kink, title in found]

    @property
    def follows_accelerations(self) -> bool:
        """Do signals follow accelerations?"""
        return any(atom.sort == ACCELERATION for atom in self.atoms)

    @property
    def follows_reactions(self) -> tuple[str, ...]:
        """The joints whose reactions signals follow, at sample times."""
        return tuple(dict.fromkeys(atom.part for atom in self.atoms if atom.sort == REACTION))


def _called(signal: Signal) -> str:
    """Return how a message calls a signal: by its name, or that of the sensor that is read."""
    if isinstance(signal, Measurement):
        return f"sensor '{signal.of if isinstance(signal.of, str) else signal.of.name}'"
    return getattr(signal, "name", None) or signal.word
