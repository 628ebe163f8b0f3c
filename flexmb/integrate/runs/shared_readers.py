"""What acts with reactions that are not unique: the motion then depends on how joints share a load.

Without stiffness nobody knows how redundant joints share it. Multipliers of least norm are one choice of many, so
friction that grows with such a reaction, a sampler that reads it and an event that waits for it are arbitrary, too.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from flexmb.errors import ValidityWarning
from flexmb.math.weights import no_matrix
from flexmb.model.sensor_columns import found_in
from flexmb.system.program import evaluate

__all__ = ["SharedReaders", "shared_reactions_act"]

SHARE = 1e-6
"""Of the largest multiplier, from which on a reaction counts: below it nothing changes that a run can tell."""


class SharedReaders:
    """Looks for the reactions that are not unique and that something acts with.

    Parameters
    ----------
    system : System
        Of the phase.
    """

    def __init__(self, system: Any):
        shared = set(system.indeterminate) if system.redundant else set()
        self.system = system
        self._readers: list[tuple[str, str, list[int], Any]] = []
        for title, joint, force in _readers(system) if shared else ():
            span = system.joint_equations[joint]
            rows = [k for k in range(span.start, span.stop) if k in shared]
            if rows:
                self._readers.append((title, joint, rows, force))
        self._least = 0.0

    def __bool__(self) -> bool:
        return bool(self._readers)

    def sentences(self, lam: np.ndarray, work: Any) -> list[str]:
        """Return a warning for each reader whose reactions are not zero in samples; `work` is that of a state there.

        Parameters
        ----------
        lam : (nt, ng), N and N m
        work : Work
            With equations and markers of one of the samples.
        """
        sizes = np.abs(lam).max(axis=0, initial=0.0)
        self._least = max(self._least, SHARE * float(sizes.max(initial=0.0)))
        told, left = [], []
        for reader in self._readers:
            title, joint, rows, force = reader
            felt = [k for k in rows if force is None or force.feels(self.system, work, k)]
            loaded = [k for k in felt if sizes[k] > self._least]
            if not loaded:
                left.append(reader)
                continue
            names = ", ".join(self.system.equation_names[k].rpartition(": ")[2] for k in loaded)
            told.append(
                f"{title} acts with the reaction of joint '{joint}', which is not unique ({names}); expected: a joint "
                "that shares no load with others. Rigid bodies do not tell how they share it, so the motion is one of "
                "many. flexmb.check lists the equations and says how to make them unique"
            )
        self._readers = left
        return told


def shared_reactions_act(system: Any, state: Any, lam: np.ndarray) -> list[str]:
    """Warn of what acts with reactions that are not unique in an analysis that is no run, and return the sentences.

    Parameters
    ----------
    system : System
    state : State
        Of the analysis, where it is looked at what feels the reactions.
    lam : (nt, ng), N and N m
        Multipliers of all its states.
    """
    readers = SharedReaders(system)
    if not readers:
        return []
    work = system.workspace()
    no_matrix(work.weights)
    evaluate(system.program, state, work)
    sentences = readers.sentences(lam, work)
    for sentence in sentences:
        warnings.warn(sentence, ValidityWarning, stacklevel=3)
    return sentences


def _readers(system):
    """Yield title, joint and force (None for others) of what acts with the reactions of a joint."""
    model = system.model
    for force in model.forces:
        if force.reads_reactions:
            yield force.title, force.joint, force
    for event in model.events:
        found = None if event.sensor is None else found_in(model, event.sensor)
        if found is not None and found[0].reads_reactions:
            yield event.title, found[0].joint, None
    for joint in system.samples_reactions:
        yield f"A measured reaction of joint '{joint}'", joint, None
