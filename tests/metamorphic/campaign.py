"""A long campaign of metamorphic relations: every analysis of every random mechanism in every way.

    cd tests
    python -m metamorphic.campaign --seeds 100:200                        # all analyses
    python -m metamorphic.campaign --seeds 7 --analyses IDA,statics --ways units,mirror
    python -m metamorphic.campaign --seeds 100:200 --extras               # with contacts, friction, stops, ...
    python -m metamorphic.campaign --seeds 100:200 --trees                # reduced bodies, split ones, loops of them

Prints a line for every relation that does not hold, with the seed that repeats it, and at the end how many were tried.
"""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Iterator

import numpy as np
from metamorphic.analyses import ANALYSES, INTEGRATORS, OF_DRIVEN, WITHOUT_TIME, analysed, worst_difference
from metamorphic.extras import KINDS_AND_PLATES
from metamorphic.flexible_trees import flexible_tree
from metamorphic.limits import KINDS_FOR, LIMITS
from metamorphic.mechanisms import mechanism
from metamorphic.relations import RELATIONS, differs
from metamorphic.seen import CHANGES, PLAIN

import flexmb as fmb

UNSTABLE = "an unstable equilibrium"
"""On which of several equilibria a search ends depends on how it is written down; that one of them is unstable is told,
and no result is compared with it."""


def kinds_for(how: str, extras: bool = False) -> dict:
    """Return the kinds of bodies that an analysis takes, and whether contacts and the like are added."""
    kinds = {"kinds": KINDS_FOR[how]} if how in KINDS_FOR else {"kinds": KINDS_AND_PLATES} if extras else {}
    return {**kinds, "extras": extras}


def drawn(seed: int, how: str, seen=PLAIN, extras: bool = False, trees: bool = False) -> fmb.Model:
    """Return the random mechanism, or flexible tree, of a seed for an analysis, as it is seen."""
    if trees:
        return flexible_tree(seed, seen, extras=extras, held=how == "statics", driven=how == "kinematics")
    return mechanism(seed, seen, **kinds_for(how, extras))


def outcome(model: fmb.Model, how: str, *seen):
    """Return the results of an analysis, or the name of the error it ends with, or that its result is UNSTABLE."""
    try:
        return analysed(model, how, *seen)
    except fmb.FlexmbError as error:
        return f"{type(error).__name__}: {error}"
    except fmb.ValidityWarning:
        return UNSTABLE


def _told(seen) -> str:
    """Return the units of a way; turns and places follow from the seed."""
    sizes = {name: getattr(seen, name) for name in ("length", "mass", "time")}
    return ", ".join(f"{name} {size:.3g}" for name, size in sizes.items() if size != 1.0) or "SI units"


def way_holds(seed: int, how: str, change: str, plain=None, **options: bool) -> tuple[bool, str]:
    """Does an analysis give the same when the mechanism is written down in another way? And what it found."""
    seen = CHANGES[change](np.random.default_rng(seed))
    mine = outcome(drawn(seed, how, **options), how) if plain is None else plain
    other = outcome(drawn(seed, how, seen, **options), how, seen)
    if UNSTABLE in (mine, other):
        return True, ""
    if isinstance(mine, str) or isinstance(other, str):
        both = isinstance(mine, str) and isinstance(other, str)
        return both, f"plain: {mine if isinstance(mine, str) else 'found'}; {change}: {str(other)[:200]}"
    share, where = worst_difference(mine, other)
    return share <= LIMITS[how], f"{where}: {share:.1e}, limit {LIMITS[how]:.0e}; {_told(seen)}"


def relation_holds(seed: int, how: str, name: str, **options: bool) -> tuple[bool, str]:
    """Does a motion stay the same when the mechanism is changed in a way that must not matter?"""
    model = drawn(seed, how, **options)
    if isinstance(outcome(model, how), str):  # neither has a motion
        return True, ""
    try:
        share, where = differs(model, RELATIONS[name](model, np.random.default_rng(seed)), how)
    except fmb.FlexmbError as error:
        return False, f"{type(error).__name__}: {str(error)[:200]}"
    return share <= LIMITS[how], f"{where}: {share:.1e}, limit {LIMITS[how]:.0e}"


def campaign(seeds, analyses, ways, **options: bool) -> Iterator[tuple[str, bool, str]]:
    """Yield (what, does it hold, what was found)."""
    for seed in seeds:
        for how in analyses:
            plain = outcome(drawn(seed, how, **options), how)
            for change in ways:
                if change in CHANGES and not (change == "start" and how in WITHOUT_TIME):
                    yield f"seed {seed}, {how}, {change}", *way_holds(seed, how, change, plain, **options)
                elif change in RELATIONS and (how in ("steps", "IDA") or options.get("trees")) and how in INTEGRATORS:
                    yield f"seed {seed}, {how}, {change}", *relation_holds(seed, how, change, **options)


def main(arguments=None) -> int:
    """Run the campaign that the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="0:20", help="a seed, or FIRST:END")
    parser.add_argument("--analyses", help="all that there are, of trees those of driven ones too")
    parser.add_argument("--ways", default=",".join((*CHANGES, *RELATIONS)))
    parser.add_argument("--extras", action="store_true", help="with contacts, friction, stops, equations, attraction")
    parser.add_argument("--trees", action="store_true", help="trees and loops of reduced bodies, whole and split")
    given = parser.parse_args(arguments)
    first, _, end = given.seeds.partition(":")
    seeds = range(int(first), int(end) if end else int(first) + 1)
    analyses = given.analyses.split(",") if given.analyses else (*ANALYSES, *(OF_DRIVEN if given.trees else ()))
    options = {"extras": given.extras, "trees": given.trees}
    tried = failed = 0
    warnings.simplefilter("ignore")
    for what, holds, found in campaign(seeds, analyses, given.ways.split(","), **options):
        tried += 1
        if not holds:
            failed += 1
            print(f"{what}: {found}", flush=True)
    print(f"{tried} relations, {failed} do not hold")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
