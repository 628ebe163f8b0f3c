"""List or clear the reduced parts that model files have described.

Examples:
  flexmb cache
  flexmb cache --clear
  flexmb cache --clear lever flap

A part is reduced once for all processes and sweeps; the folder is FLEXMB_BODIES, or in the user's cache folder.
Every file is read: one that is damaged, or holds another part than its name says, is named; it is not used.
Nothing is lost when the cache is cleared: what is needed again is reduced again.
"""

from __future__ import annotations

import argparse
import time

from flexmb.cli.run import aligned
from flexmb.errors import did_you_mean

NAME = "cache"
SUMMARY = "list or clear the reduced parts of model files"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("names", nargs="*", help="only parts of these names")
    parser.add_argument("--clear", action="store_true", help="remove them")


def execute(arguments: argparse.Namespace) -> int:
    from flexmb import parts

    names = tuple(arguments.names)
    held = parts.kept_bodies()
    known = sorted(set().union(*(entry.names for entry in held)))
    for name in names:
        if name not in known:
            print(f"There is no part '{name}'. {did_you_mean(name, known)}".strip())
    if arguments.clear:
        wanted = tuple(name for name in names if name in known)
        removed = parts.clear_bodies(wanted) if wanted or not names else []
        print(f"Removed {len(removed)} parts, {sum(entry.size for entry in removed) / 1e6:.1f} MB")
        return 0
    shown = [entry for entry in held if not names or entry.names & set(names)]
    rows: list[tuple[str, ...]] = [("part", "MB", "last used", "file")]
    for entry in shown:
        used = time.strftime("%Y-%m-%d %H:%M", time.localtime(entry.used))
        rows.append((entry.name, f"{entry.size / 1e6:.2f}", used, entry.path.name))
    if shown:
        print("\n".join(aligned(rows)))
    for entry in shown:
        if entry.wrong:
            print(f"{entry.path.name}, {entry.wrong}. It is not used: the part is reduced again")
    former = [entry for entry in shown if not entry.current]
    if former:
        size = sum(entry.size for entry in former) / 1e6
        print(f"{len(former)} of them, {size:.1f} MB, are of another version of flexmb: this one does not use them")
    total = sum(entry.size for entry in shown)
    print(f"{len(shown)} parts, {total / 1e6:.1f} MB in {parts.body_folder()}")
    return 0
