"""The absolute numbers of the page on tolerances are those of the code, and the other way round.

Each row of the page names the places where its numbers stand: comparisons of the family "absolute", or lines of a file
for numbers that are no comparison.
"""

import ast
import re
from pathlib import Path

import pytest
from architecture.test_thresholds import KNOWN, ROOT

PAGE = Path(__file__).parents[2] / "docs" / "theory" / "tolerances.md"
RUN = "integrate/explicit/compiled_run.py"
PLACES = {
    "`atol` of `Explicit` and `IDA`": (
        "integrate/explicit/tolerances.py: ATOL = 1e-10",
        "integrate/ida/run.py: ATOL = 1e-8",
    ),
    "`UserForce`, differences by rates": ("forces/user_force.py: STEP = 1e-6",),
    "plausibility of meshes and materials": (
        "model/plausibility.py: SIZE = (1e-5, 150.0)",
        "model/plausibility.py: WAVE_SPEED = (30.0, 30e3)",
    ),
    "how far a state is moved to see turns counted": ("system/branches.py: PROBE = 1e-4",),
    "largest step when loops are closed in joint coordinates": ("tree/rigid/motion.py: 0.5 / max(stride, 1e-300)",),
    "friction and stops": (
        "forces/joint_friction.py: transition: float = 1e-3",
        "forces/contact.py: transition: float = 1e-3",
        "forces/bi_stop.py: depth: float = 1e-4",
    ),
    "stream from behind that `Airload` takes for rounding": ("forces/airload.py: speed < BACKWARDS",),
    "`Explicit`, whether a stage has settled": (
        "integrate/explicit/body_steps.py: SMALL = 1e-10",
        "integrate/explicit/body_steps.py: largest, change, force, correction = 1.0, 0.0, 1.0, 0.0",
    ),
    "times below count as this where just before and after a jump is 1e-12 of the time": (
        "integrate/runs/breaks.py: np.maximum(np.abs(t), 1e-06)",
    ),
    "first step of `Explicit` where speed or position is zero; least span": (
        f"{RUN}: max(CAUTIOUS, 0.001 * h)",
        f"{RUN}: max(t_end - state.t, 1e-12)",
        "integrate/explicit/explicit.py: min(CAUTIOUS, abs(solver.t_bound - t))",
    ),
    "speed and position, in tolerances, that count as zero there": (
        f"{RUN}: max(d1, d2) <= 1e-15",
        f"{RUN}: min(d0, d1) < 1e-05",
    ),
    "least frequency by which `verify` chooses its differences (`trust`)": (
        "trust/balance.py: max(change / speed if speed > 0.0 else 0.0, turning, 0.001)",
        "trust/levels.py: max(speed / size, np.sqrt(change / size), 0.001)",
    ),
    "change of a constraint's acceleration in a motion called steady that does not turn": (
        "integrate/linear/steady.py: max(fastest ** 2 * size, 1e-12)",
    ),
    "gradient of an equation of the user that counts as flat (`complaints`)": (
        "system/complaints.py: max(system.lengths.whole * own, FLAT)",
        "system/complaints.py: np.max(np.abs(gradients), initial=0.0) > 1e-06",
        "system/complaints.py: own <= FLAT",
        "system/complaints.py: own > FLAT",
    ),
    "derivative of a function of a constraint, below which it is compared absolutely (`by_function`)": (
        "constraints/by_function.py: max(abs(difference), abs(found), 0.001)",
    ),
    "markers of two grounds that are one (`assembly`), beside 1e-5 of them": (
        "model/assembly.py: np.allclose(old.at, pose.at, atol=1e-12)",
    ),
    "start of a run that `verify` takes for the one described (`trust`)": (
        "trust/reruns.py: np.allclose(q0[bodies], old.q0[bodies], rtol=0.0, atol=1e-09)",
        "trust/reruns.py: np.allclose(u0, old.u0, atol=1e-09)",
    ),
    "density of a material of a deck that has none": (
        "fem/deck/abaqus_lines.py: max(density, LOWEST)",
        "fem/deck/ansys_lines.py: max(material.density, LOWEST)",
        "fem/deck/nastran_lines.py: max(density, LOWEST)",
    ),
    "density of a deck, in its units, that counts as none where units are judged": (
        "fem/deck/unit_doubts.py: rho > 1e-25",
    ),
    "least reach of an arm whose inverse kinematics is asked for (`reach`)": (
        "tree/coordinates/reach.py: max(1e-09, float(np.linalg.norm(J[:3, self.rates], axis=0).max(initial=0.0)))",
    ),
}
"""By row of the page: file, and comparison or words of a line."""
NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d+)?(?:e-?\d+)?(?![\w.])")


def rows() -> dict[str, str]:
    """Return the numbers of each row of the page's table of absolute numbers, by its place."""
    table = PAGE.read_text(encoding="utf-8").partition("Absolute, each for its reason:")[2]
    cells = [line.strip("|").split(" | ") for line in table.splitlines() if line.startswith("| ")]
    return {row[1].strip(): row[0].strip() for row in cells[1:]}


def numbers_of(place: str) -> set[float]:
    """Return the numbers of a place, those behind its names too, without signs."""
    path, _, words = place.partition(": ")
    tree = ast.parse((ROOT / path).read_text(encoding="utf-8"))
    found = {float(text) for text in NUMBER.findall(words)}
    names = set(re.findall(r"\b[A-Z_]{3,}\b", words))
    modules = [tree]
    for node in tree.body:
        if isinstance(node, ast.ImportFrom) and names & {one.name for one in node.names}:
            other = ROOT.parent / (str(node.module).replace(".", "/") + ".py")
            modules.append(ast.parse(other.read_text(encoding="utf-8")))
    for node in (node for module in modules for node in module.body if isinstance(node, ast.Assign)):
        if isinstance(node.targets[0], ast.Name) and node.targets[0].id in names:
            found |= {abs(n.value) for n in ast.walk(node.value) if isinstance(n, ast.Constant)}
    return found


def test_the_page_has_these_rows_and_no_other():
    assert set(rows()) == set(PLACES)


def test_every_absolute_comparison_has_a_row():
    named = {place for places in PLACES.values() for place in places}
    missing = set(KNOWN["absolute"]) - named
    assert not missing, "say in docs/theory/tolerances.md why, and here where: " + "; ".join(sorted(missing))


@pytest.mark.parametrize("row", PLACES)
def test_places_stand_in_the_code_with_the_numbers_of_the_page(row):
    numbers = set()
    for place in PLACES[row]:
        path, _, words = place.partition(": ")
        assert place in KNOWN["absolute"] or words in (ROOT / path).read_text(encoding="utf-8")
        numbers |= numbers_of(place)
    told = {float(text) for text in NUMBER.findall(rows()[row])}
    assert told, row
    assert told <= numbers, (told, numbers)
