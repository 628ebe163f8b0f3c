"""A campaign: many inputs one after another in forked workers with limits of time and memory, and what came of each.

A worker that dies or hangs costs one input: the next worker goes on behind it. Works where processes can be forked.
"""

from __future__ import annotations

import faulthandler
import gc
import os
import resource
import select
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from dataclasses import dataclass, field
from pathlib import Path

from flexmb.errors import FlexmbError

__all__ = ["KINDS", "Campaign", "Outcome", "prepared", "run"]

KINDS = ("read", "refused", "long", "traceback", "crash", "hang")
"""Used as it is; refused with a message of flexmb; ended by an interrupt after its time; another exception; the process
died; neither its time nor an interrupt ended it."""
MEMORY = Path("/dev/shm")
"""A file system in memory, where there is one: inputs are written and removed by the hundred thousand."""
GRACE = 5.0
"""Seconds that an input gets to answer an interrupt."""
WARM_UP = 30.0
"""Seconds more for the first input of a worker."""
PATIENCE = 12.0
"""Times its limit that an input may wait for a processor that others use: with 4, honest work of 5 s was cut off on a
machine with eight times as many busy processes as processors."""


@dataclass(frozen=True)
class Campaign:
    """What is tried: `prepare` fills a folder once, `make` writes input k there, `use` does with it what a user does.

    Parameters
    ----------
    prepare : callable (folder)
    make : callable (folder, k) -> path of input k
    use : callable (path)
    limit : float, s
        Longest time of one input, of the processor.
    may_be_long : bool
        Is it all right to need longer, if an interrupt ends it? Of a simulation it is, of reading a file it is not.
    memory : int, bytes
        What a worker may take beyond what it has when it begins.
    warm : callable (folder) -> paths
    """

    name: str
    prepare: Callable[[Path], None]
    make: Callable[[Path, int], Path]
    use: Callable[[Path], None]
    limit: float = 10.0
    may_be_long: bool = False
    memory: int = 3 << 30
    warm: Callable[[Path], list[Path]] = lambda folder: []
    """Sound inputs, used once before workers are forked: all of them then have the imports and the kernels."""


@dataclass
class Outcome:
    """How often each of `KINDS` came, and where: (kind, signature) with count and the first input."""

    may_be_long: bool = False
    counts: Counter[str] = field(default_factory=Counter)
    causes: dict[tuple[str, str], list[int]] = field(default_factory=dict)
    samples: dict[tuple[str, str], str] = field(default_factory=dict)

    @property
    def inputs(self) -> int:
        return sum(self.counts.values())

    @property
    def bad(self) -> int:
        return sum(self.counts[kind] for kind in KINDS[2 + self.may_be_long :])

    def add(self, kind: str, signature: str, k: int) -> None:
        self.counts[kind] += 1
        if kind in KINDS[2:]:
            place, _, text = signature.partition(": ")
            self.causes.setdefault((kind, place), []).append(k)
            self.samples.setdefault((kind, place), text)

    def report(self) -> str:
        rows = sorted(self.causes.items(), key=lambda item: -len(item[1]))
        return "\n".join(
            f"{len(ks):6d} {cause[0]:9s} {cause[1]}: {self.samples[cause]}  (inputs {ks[:4]})" for cause, ks in rows
        )


@contextmanager
def prepared(campaign: Campaign, *, batch: int = 500, warmed: bool = True) -> Iterator[Callable[..., Outcome]]:
    """Give a function that tries inputs: number of the first, how many, and the folder for bad ones or None.

    Its workers are forks of this process and do `batch` inputs each; `warmed`: they find imports and kernels there."""
    with tempfile.TemporaryDirectory(dir=MEMORY if MEMORY.is_dir() else None) as name:
        folder = Path(name)
        campaign.prepare(folder)
        if warmed:
            _warmed(campaign, folder)

        def tried(first: int, count: int, keep: Path | None = None) -> Outcome:
            outcome, k, end = Outcome(campaign.may_be_long), first, first + count
            while k < end:
                k = _batch(campaign, folder, k, min(k + batch, end), outcome, keep)
            return outcome

        yield tried


def run(campaign: Campaign, first: int, count: int, *, batch: int = 500, keep: Path | None = None) -> Outcome:
    """Try inputs `first` to `first + count`; bad ones are copied to the folder `keep`."""
    with prepared(campaign, batch=batch, warmed=count > batch) as tried:
        return tried(first, count, keep)


def _warmed(campaign: Campaign, folder: Path) -> None:
    """Use sound inputs once in this process."""
    with warnings.catch_warnings(), redirect_stdout(None), redirect_stderr(None):
        warnings.simplefilter("ignore")
        for path in campaign.warm(folder):
            with suppress(FlexmbError):
                campaign.use(path)
    gc.collect()
    gc.freeze()  # pages that workers need not copy


def _batch(campaign: Campaign, folder: Path, start: int, end: int, outcome: Outcome, keep: Path | None) -> int:
    """Let one worker do inputs from `start`; return the number of the next input to do."""
    reader, writer = os.pipe()
    notes = folder.parent / f"{folder.name}.notes"
    sys.stdout.flush()
    worker = os.fork()
    if worker == 0:
        os.close(reader)
        os.setpgid(0, 0)  # what it starts dies with it
        _work(campaign, folder, start, end, writer, notes, keep)
    os.close(writer)
    k, text, begun, used = start, b"", time.monotonic(), 0.0
    try:
        while k < end:
            ready, _, _ = select.select([reader], [], [], 0.5)
            spare = WARM_UP if k == start else 0.0
            waited, worked = time.monotonic() - begun, _processor_time(worker) - used
            if not ready and worked < campaign.limit + spare and waited < PATIENCE * campaign.limit + spare:
                continue
            if not ready:
                where = _stop(worker, notes)
                answered = select.select([reader], [], [], GRACE)[0]
                outcome.add("long" if answered else "hang", where, k)
                _end(worker)
                worker = 0
                _kept(keep, campaign, folder, k)
                return k + 1
            piece = os.read(reader, 1 << 16)
            if not piece:
                _, status = os.waitpid(worker, 0)
                worker = 0
                outcome.add("crash", f"status {status}: {_noted(notes)}", k)
                _kept(keep, campaign, folder, k)
                return k + 1
            *lines, text = (text + piece).split(b"\n")
            for line in lines:
                kind, _, signature = line.decode(errors="replace").partition("\t")
                outcome.add(kind, signature, k)
                k += 1
                begun, used = time.monotonic(), _processor_time(worker)
    finally:
        os.close(reader)
        if worker:
            _end(worker)
        notes.unlink(missing_ok=True)
    return k


def _end(worker: int) -> None:
    try:
        os.killpg(worker, signal.SIGKILL)
    except ProcessLookupError:
        os.kill(worker, signal.SIGKILL)
    os.waitpid(worker, 0)


def _stop(worker: int, notes: Path) -> str:
    """Interrupt a worker and say where it was."""
    os.kill(worker, signal.SIGUSR1)
    time.sleep(0.3)
    where = _noted(notes)
    os.kill(worker, signal.SIGINT)
    return where


def _processor_time(worker: int) -> float:
    """Return the seconds that a worker and the processes it waited for have used, 0 if it is gone."""
    try:
        words = Path(f"/proc/{worker}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return sum(map(int, words[11:15])) / os.sysconf("SC_CLK_TCK")


def _kept(keep: Path | None, campaign: Campaign, folder: Path, k: int) -> None:
    if keep is not None:
        keep.mkdir(parents=True, exist_ok=True)
        made = campaign.make(folder, k)
        shutil.copy(made, keep / f"{campaign.name}_{k}_{made.name}")


def _noted(notes: Path) -> str:
    """Return the innermost lines of flexmb in what faulthandler wrote, else the innermost lines."""
    lines = notes.read_text(errors="replace").splitlines() if notes.is_file() else []
    files = [line.strip() for line in lines if line.strip().startswith("File ")]
    own = [line for line in files if "/flexmb/" in line]
    return " < ".join(
        line.replace('File "', "").replace('", line ', ":").rpartition("/")[2] for line in [*own, *files][:3]
    )


def _work(campaign: Campaign, folder: Path, start: int, end: int, writer: int, notes: Path, keep: Path | None) -> None:
    """The life of a worker."""
    stream = notes.open("w")
    faulthandler.enable(stream)
    faulthandler.register(signal.SIGUSR1, stream)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    warnings.simplefilter("ignore")
    null = os.open(os.devnull, os.O_RDWR)
    os.dup2(null, 1)
    os.dup2(null, 2)
    size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (size + campaign.memory, size + campaign.memory))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    for k in range(start, end):
        signature = ""
        try:
            campaign.use(campaign.make(folder, k))
            kind = "read"
        except FlexmbError:
            kind = "refused"
        except KeyboardInterrupt:
            kind = "long"
        except BaseException as error:
            kind, signature = "traceback", _signature(error)
            _kept(keep, campaign, folder, k)
        os.write(writer, f"{kind}\t{signature}\n".encode(errors="replace"))
    os._exit(0)


def _signature(error: BaseException) -> str:
    """Name an exception by its type and the innermost lines of flexmb that it passed."""
    frames = [f for f in traceback.extract_tb(error.__traceback__) if "/flexmb/" in f.filename]
    places = [f"{Path(f.filename).name}:{f.lineno}" for f in frames[-2:]]
    return f"{type(error).__name__} {' < '.join(reversed(places))}: {' '.join(str(error).split())[:70]}"
