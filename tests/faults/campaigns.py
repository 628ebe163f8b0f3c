"""Campaigns of faults: processes ended before every write and at random moments, full disks, limits, two at a time.

``python tests/faults/campaigns.py`` runs all of them and prints a table; ``--cases 20`` a short one, ``--seed 2`` with
other random numbers, ``--only kill`` those whose name has the word, ``--scene bounce`` on another model. It ends with 1
if anything was lost, or told by a traceback. Where a C compiler is there, it builds and preloads `shim.c` by itself.
"""

from __future__ import annotations

import argparse
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from faults.bench import SAMPLES, SCENES, Bench, Counts
from faults.children import begin, ended, shim
from faults.pairs import pairs_of_verbs
from faults.saves import kill_saves
from faults.verbs import all_verbs

from flexmb import fmi, io, study, view

LOADED = (fmi, io, study, view)
"""What the commands import; in the forks it is there already."""


def kill_before_writes(bench: Bench, torn: bool = False) -> Counts:
    """End the run before each call that changes a file (torn: in the middle of each write)."""
    counts, library = Counts(), shim()
    if library is None:
        return counts
    place = str(bench.run).encode()

    def at(number: int) -> Callable[[], None]:
        return lambda: library.faults_begin(place, number, torn)

    bench.clear()
    for number in bench.chosen(ended(bench.start(before=at(-1))).calls):
        bench.clear()
        end = ended(bench.start(before=at(number)))
        counts.crashes += end.code not in (-signal.SIGKILL, 0)  # by the clock, it may write more rarely this time
        bench.judge(counts, end.promised, f"write {number}", killed=True)
    return counts


def kill_resume_before_writes(bench: Bench) -> Counts:
    """End `resume` of a run that was cut off before each call that changes a file."""
    counts, library = Counts(), shim()
    if library is None:
        return counts
    place, kept, resume = str(bench.run).encode(), bench.folder / "cut", ["resume", str(bench.run)]

    def at(number: int) -> Callable[[], None]:
        return lambda: library.faults_begin(place, number, False)

    bench.clear()
    for number in range(ended(bench.start(before=at(-1))).calls):
        bench.clear()
        cut = ended(bench.start(before=at(number)))
        if cut.promised >= SAMPLES // 2:
            break
    shutil.copytree(bench.run, kept)
    for number in bench.chosen(ended(begin(resume, at(-1))).calls):
        bench.clear()
        shutil.copytree(kept, bench.run)
        end = ended(begin(resume, at(number)))
        counts.crashes += end.code not in (-signal.SIGKILL, 0)  # by the clock, it may write more rarely this time
        bench.judge(counts, cut.promised + end.promised, f"write {number}", killed=True)
    return counts


def signals(bench: Bench, number: int) -> Counts:
    """Send a signal at random moments; a polite one must be heard soon."""
    counts = Counts()
    for k in bench.times(100):
        bench.clear()
        child = bench.start()
        time.sleep(bench.random.uniform(0.0, 1.2 * bench.seconds))
        sent = time.monotonic()
        os.kill(child.pid, number)
        end = ended(child)
        counts.take(end, f"moment {k}", slow=sent - child.began + 5.0)
        bench.judge(counts, end.promised, f"moment {k}", killed=number == signal.SIGKILL)
    return counts


def file_size_limits(bench: Bench) -> Counts:
    """Let files not grow beyond random sizes: all verbs that write."""
    counts = Counts()
    largest = (bench.folder / "reference" / "solution.h5").stat().st_size
    for _ in bench.times(60):
        bench.clear()
        size = int(largest * bench.random.uniform(0.0, 1.3) ** 2)
        end = ended(bench.start(before=lambda size=size: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))))
        counts.take(end, f"run, {size} bytes")
        bench.judge(counts, end.promised, f"run, {size} bytes")
    return all_verbs(
        bench,
        counts,
        lambda: bench.random.choice((0, 100, 5000)),
        lambda n: resource.setrlimit(resource.RLIMIT_FSIZE, (n, n)),
    )


def memory_limits(bench: Bench) -> Counts:
    """Let processes have little memory beyond what they have when they begin."""
    pages = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    counts = Counts()
    for _ in bench.times(40):
        bench.clear()
        more = int(2 ** bench.random.uniform(16, 27))
        end = ended(bench.start(before=lambda more=more: resource.setrlimit(resource.RLIMIT_AS, (pages + more,) * 2)))
        counts.take(end, f"run, {more} bytes more")
        bench.judge(counts, end.promised, f"run, {more} bytes more")
    return all_verbs(
        bench,
        counts,
        lambda: int(2 ** bench.random.uniform(20, 28)),
        lambda more: resource.setrlimit(resource.RLIMIT_AS, (pages + more,) * 2),
    )


def read_only(bench: Bench) -> Counts:
    """Write into folders that may not be written."""
    closed = bench.folder / "closed"
    shutil.copytree(bench.folder / "reference", closed / "run")
    with _closed(closed):
        return all_verbs(bench, Counts(), lambda: 0, lambda _: None, closed)


def full_disk(bench: Bench) -> Counts:
    """Write to a small file system (as root, else there are no cases)."""
    counts = Counts()
    for _ in bench.times(30):
        kilobytes = 4 * bench.random.randint(1, 120)
        with _small_disk(bench.run.parent, kilobytes) as mounted:
            if not mounted:
                return counts
            end = ended(bench.start())
            counts.take(end, f"run, {kilobytes} kB")
            saved = bench.folder / "saved"
            shutil.rmtree(saved, ignore_errors=True)
            if bench.run.is_dir():
                shutil.copytree(bench.run, saved)
        bench.clear()
        if saved.is_dir():
            shutil.copytree(saved, bench.run)
        bench.judge(counts, end.promised, f"run, {kilobytes} kB")
    (crowded := bench.folder / "crowded").mkdir(exist_ok=True)
    size = sum(path.stat().st_size for path in (bench.folder / "reference").iterdir())
    with _small_disk(crowded, size // 1024 + 40) as mounted:
        return all_verbs(bench, counts, lambda: 0, lambda _: None, crowded) if mounted else counts


def deleted_folder(bench: Bench) -> Counts:
    """Remove the folder while the run writes into it: every sample that its end speaks of must be there."""
    counts = Counts()
    for k in bench.times(20):
        bench.clear()
        child = bench.start()
        time.sleep(bench.random.uniform(0.2, 1.0) * bench.seconds)
        bench.clear()
        end = ended(child)
        counts.take(end, f"moment {k}")
        if end.code == 0 and not (bench.run / "solution.h5").exists():  # removed behind its last look, at its end
            counts.cases += 1
            continue
        said = re.search(r"(\d+) samples, t", end.text)
        bench.judge(counts, int(said[1]) if said else 0, f"moment {k}, code {end.code}")
    (gone := bench.folder / "gone").mkdir(exist_ok=True)
    return all_verbs(bench, counts, lambda: 0, lambda _: None, gone, removed_after=0.3)


def two_at_a_time(bench: Bench) -> Counts:
    """Two processes at the same run folder, body, or study."""
    counts = Counts()
    run = ["run", str(bench.model), "--out", str(bench.run)]
    resume, export = ["resume", str(bench.run)], ["export", str(bench.run), "--csv"]
    pairs = [(run, run), (run, [*run, "--overwrite"]), (run, resume), (run, export), ([*run, "--overwrite"],) * 2]
    for k in bench.times(50):
        first, second = pairs[k % len(pairs)]
        bench.clear()
        one = begin(first)
        time.sleep(bench.random.uniform(0.0, 0.8) * bench.seconds)
        two = begin(second)
        ends = [ended(one), ended(two)]
        what = f"{first[0]} and {' '.join(second[:1] + second[4:])}"
        for end in ends:
            counts.take(end, what)
        if not any(end.code == 0 for end in ends):
            counts.refused += 1
            counts.notes.append(f"{what}: both were refused: {ends[0].text[-300:]} {ends[1].text[-300:]}")
        bench.judge(counts, SAMPLES, what)
    return counts


@contextmanager
def _small_disk(folder: Path, kilobytes: int) -> Iterator[bool]:
    """Mount a small file system on a folder; give whether that was possible."""
    options = ["-t", "tmpfs", "-o", f"size={kilobytes}k,mode=777", "tmpfs", str(folder)]
    mounted = (
        shutil.which("mount") is not None
        and not subprocess.run(["mount", *options], capture_output=True, check=False).returncode
    )
    try:
        yield mounted
    finally:
        if mounted:
            subprocess.run(["umount", str(folder)], check=True)


@contextmanager
def _closed(folder: Path) -> Iterator[None]:
    """Make a folder read-only: by its mode, and for root, who may write all the same, by a mount."""
    mounted = os.getuid() == 0 and not any(
        subprocess.run(["mount", *options, folder], capture_output=True, check=False).returncode
        for options in (["--bind", folder], ["-o", "remount,bind,ro"])
    )
    if not mounted:
        for path in (folder / "run", folder):
            os.chmod(path, 0o555)
    try:
        yield
    finally:
        if mounted:
            subprocess.run(["umount", folder], check=True)
        else:
            for path in (folder, folder / "run"):
                os.chmod(path, 0o755)


CAMPAIGNS: dict[str, Callable[[Bench], Counts]] = {
    "kill before every write": kill_before_writes,
    "kill inside every write": lambda bench: kill_before_writes(bench, torn=True),
    "kill resume before every write": kill_resume_before_writes,
    "kill at random": lambda bench: signals(bench, signal.SIGKILL),
    "Ctrl-C at random": lambda bench: signals(bench, signal.SIGINT),
    "SIGTERM at random": lambda bench: signals(bench, signal.SIGTERM),
    "limit of file size": file_size_limits,
    "limit of memory": memory_limits,
    "full disk": full_disk,
    "read-only folder": read_only,
    "deleted folder": deleted_folder,
    "two processes": two_at_a_time,
    "two verbs at a time": pairs_of_verbs,
    "kill a loop of saves": kill_saves,
}


def _preloaded() -> None:
    """Start again with the shim preloaded, if there is a compiler."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if shim() is not None or compiler is None or "FLEXMB_FAULTS" in os.environ or sys.platform != "linux":
        return
    library = Path(tempfile.mkdtemp()) / "shim.so"
    source = Path(__file__).with_name("shim.c")
    subprocess.run([compiler, "-shared", "-fPIC", "-O1", "-o", library, source, "-ldl"], check=True)
    os.environ.update(LD_PRELOAD=str(library), FLEXMB_FAULTS="preloaded")
    os.execv(sys.executable, [sys.executable, *sys.argv])


def execute() -> int:
    """Run the campaigns that are asked for and print their table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, help="at most so many of each; default: all")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="campaigns whose name has this in it")
    parser.add_argument("--scene", choices=[*SCENES], default="swing", help="model; default: swing")
    given = parser.parse_args()
    _preloaded()
    print("| campaign | cases | lost | not finished | tracebacks | crashes | hangs |\n|---|---|---|---|---|---|---|")
    bad = 0
    with tempfile.TemporaryDirectory() as folder:
        os.chmod(folder, 0o755)
        bench = Bench(Path(folder).resolve(), given.seed, given.cases, given.scene)
        for name, campaign in CAMPAIGNS.items():
            if given.only not in name:
                continue
            counts = campaign(bench)
            bad += counts.bad
            numbers = (counts.cases, counts.lost, counts.refused, counts.tracebacks, counts.crashes, counts.hangs)
            print(f"| {name} | {' | '.join(map(str, numbers))} |", flush=True)
            for note in counts.notes[:5]:
                print(note, file=sys.stderr, flush=True)
    return bad > 0


if __name__ == "__main__":
    sys.exit(execute())
