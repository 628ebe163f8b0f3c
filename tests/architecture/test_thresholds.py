"""Small numbers that quantities are compared with as they stand: each is known here, with what makes it right.

A threshold without a unit's size beside it is right for pure numbers only, or absolute: then it stands in
docs/theory/tolerances.md too. A new one fails this test: make it relative, or add it to its family.
"""

import ast
import re
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import flexmb

ROOT = Path(flexmb.__file__).parent
SMALL = 1e-3
TINY = 1e-100
"""Numbers below only keep a quotient of zeros finite."""

KNOWN = {
    "absolute": (
        "model/assembly.py: np.allclose(old.at, pose.at, atol=1e-12)",
        "trust/reruns.py: np.allclose(q0[bodies], old.q0[bodies], rtol=0.0, atol=1e-09)",
        "trust/reruns.py: np.allclose(u0, old.u0, atol=1e-09)",
        "constraints/by_function.py: max(abs(difference), abs(found), 0.001)",
        "fem/deck/abaqus_lines.py: max(density, LOWEST)",
        "fem/deck/ansys_lines.py: max(material.density, LOWEST)",
        "fem/deck/nastran_lines.py: max(density, LOWEST)",
        "fem/deck/unit_doubts.py: rho > 1e-25",
        "forces/airload.py: speed < BACKWARDS",
        "integrate/explicit/compiled_run.py: max(CAUTIOUS, 0.001 * h)",
        "integrate/explicit/compiled_run.py: max(d1, d2) <= 1e-15",
        "integrate/explicit/compiled_run.py: max(t_end - state.t, 1e-12)",
        "integrate/explicit/compiled_run.py: min(d0, d1) < 1e-05",
        "integrate/explicit/explicit.py: min(CAUTIOUS, abs(solver.t_bound - t))",
        "integrate/linear/steady.py: max(fastest ** 2 * size, 1e-12)",
        "integrate/runs/breaks.py: np.maximum(np.abs(t), 1e-06)",
        "system/complaints.py: max(system.lengths.whole * own, FLAT)",
        "system/complaints.py: np.max(np.abs(gradients), initial=0.0) > 1e-06",
        "system/complaints.py: own <= FLAT",
        "system/complaints.py: own > FLAT",
        "tree/coordinates/reach.py: max(1e-09, float(np.linalg.norm(J[:3, self.rates], axis=0).max(initial=0.0)))",
        "trust/balance.py: max(change / speed if speed > 0.0 else 0.0, turning, 0.001)",
        "trust/levels.py: max(speed / size, np.sqrt(change / size), 0.001)",
    ),
    "shown to people": (
        "io/quality_page.py: share >= 0.001",
        "reduction/quality.py: body.grounding > 1e-08",
        "reduction/quality.py: numbers['static_error'] > 1e-06",
        "trust/verification.py: share >= 1e-05",
        "view/loci.py: max(float(np.abs(poles.imag).max()), 1e-12)",
        "view/loci.py: max(high - low, 1e-12)",
        "view/quantities.py: 0.001 <= size < 1000000.0",
        "view/report_model.py: share >= 0.001",
    ),
    "seconds of the clock": (
        "integrate/runs/patience.py: max(now - self._clock, 1e-06)",
        "integrate/runs/phases.py: max(spent, 0.0001)",
    ),
    "keeps a quotient finite": (
        "integrate/equilibria/descent.py: max(pull, 1e-30)",
        "integrate/equilibria/descent.py: max(tolerance * self.largest, DIGITS * self.loads, 1e-30)",
        "integrate/equilibria/path.py: max(largest, 1e-30)",
        "integrate/explicit/eighth_order.py: max(error, 1e-30)",
        "math/splines.py: square < 1e-30",
        "trust/balance.py: max(float(np.abs(u).max(initial=0.0)), 1e-30)",
    ),
    "pure numbers: angles, unit vectors, places on an element, fractions": (
        "model/assembly.py: np.allclose(old.matrix, pose.matrix, atol=1e-12)",
        "bodies/line/ancf_cable.py: np.abs(N) < 1e-15",
        "bodies/line/ancf_cable.py: size > 1e-06",
        "bodies/line/curve.py: sine < 1e-09",
        "bodies/line/tangent_frame.py: max(1.0 - tau * tau, CLOSEST)",
        "bodies/plate/places.py: np.abs(own) < 1e-14",
        "fem/deck/ansys_materials.py: max(ratios) - min(ratios) <= ALIKE",
        "fem/deck/links.py: np.abs(needed @ vectors[:, ~firm]) > 1e-06",
        "fem/deck/nastran_lines.py: b - a < CLOSEST",
        "fem/deck/nastran_links.py: abs(np.linalg.det(scaled)) < 1e-09",
        "fem/deck/nastran_links.py: np.abs(rows).max(axis=0) > 1e-09",
        "fem/deck/nastran_scalar.py: factor > SMALL",
        "fem/deck/supports.py: np.abs(np.delete(row, main)).max() < ALONG",
        "fem/deck/tie.py: np.abs(step).max() < 1e-12",
        "fem/frames/frame.py: np.linalg.norm(y, axis=1) < 0.001",
        "fem/meshes/universal_datasets.py: 1e-12 < factor < 1000000000000.0",
        "fem/meshes/universal_datasets.py: abs(found.unit * factor - 1.0) > 1e-06",
        "fem/solids/elements.py: distance[np.arange(len(found)), found].max() < 1e-12",
        "forces/cylinders_in_a_row.py: apart < _MEET",
        "io/scene.py: np.maximum(np.linalg.norm(x, axis=1), 1e-12)",
        "io/sid.py: min(errors.values()) > _IDENTITY",
        "math/rotations.py: angle < 0.0001",
        "math/rotations.py: angle < 0.001",
        "math/rotations.py: s < 1e-08",
        "math/splines.py: np.linalg.norm(first) < 1e-08",
        "model/changed_data.py: np.abs(axes.T @ axes - np.eye(3)).max() > 1e-09",
        "model/orbit.py: e > 1e-11",
        "parts/line.py: b - a <= CLOSE",
        "parts/line.py: np.diff(ordered) > CLOSE",
        "profiles/cam.py: abs(angles[-1] - 2.0 * np.pi) > 1e-06",
        "profiles/feet.py: high - low < 1e-14",
        "profiles/segments.py: abs(r.imag) < 1e-12",
        "reduction/lines.py: np.einsum('ij,ij->i', along[1:], along[:-1]) < BACKWARDS",
        "sensors/joint_coordinate.py: abs(before - now - TURN * turns) < 0.001",
        "surfaces/advancement.py: sine > 1e-12",
        "surfaces/box_pairs.py: square < PARALLEL",
        "surfaces/closed_mesh.py: size > 1e-12",
        "surfaces/edge_pairs.py: max(_along(first, 6, n), _along(first, 9, n), -_along(second, 6, n), "
        "-_along(second, 9, n)) <= LEANS",
        "surfaces/edges.py: np.abs(sine) <= FLAT",
        "surfaces/edges.py: sine > FLAT",
        "surfaces/profile_distance.py: abs(radial) < 1e-06",
    ),
    "shares of errors, tolerances, rates of convergence, ranks, matrices of unit size": (
        "forces/cylinders_in_a_row.py: share < 1e-09",
        "integrate/alpha/corrected.py: before > MEASURED",
        "integrate/alpha/corrected.py: size > MEASURED",
        "integrate/alpha/newmark.py: error <= 1e-06",
        "integrate/alpha/newmark.py: max(error, 1e-06)",
        "integrate/alpha/newmark.py: max(rate, 0.0001)",
        "integrate/alpha/newmark.py: max(rate, 1e-06)",
        "integrate/alpha/powers.py: of_states > SMALL",
        "integrate/equilibria/load_path.py: s < 1e-08",
        "integrate/equilibria/load_path.py: s > 1e-05",
        "integrate/equilibria/path.py: max(point.tangent[-1] ** 2, 1e-12)",
        "integrate/equilibria/path.py: stride <= 1e-13",
        "integrate/explicit/explicit.py: np.minimum(lengths, LONGEST, out=lengths)",
        "integrate/ida/run.py: max(YIELDING, 0.01 * misfit)",
        "integrate/ida/run.py: max(min(1.0, FARTHER * system.lengths.whole / farthest), LEAST)",
        "integrate/implicit/through.py: max(error, 1e-06)",
        "integrate/linear/campbell.py: self.damping_ratios > -1e-07",
        "cli/modes.py: abs(ratio) < UNDAMPED",
        "integrate/linear/first_frequencies.py: abs(value) * self.mu >= NOTHING",
        "integrate/linear/plant.py: share > ACCURATE",
        "integrate/nonsmooth/cone.py: abs(step) < ROUNDING",
        "integrate/nonsmooth/course.py: self.change <= 1e-07",
        "integrate/nonsmooth/course.py: self.change <= SETTLED",
        "integrate/nonsmooth/newton.py: max(softness, SOFT)",
        "integrate/nonsmooth/step.py: course.change <= LEAST",
        "integrate/runs/continuity.py: largest[0] > JUMP",
        "integrate/runs/energy_watch.py: way < REST",
        "math/definiteness.py: np.linalg.eigvalsh(scaled)[0] > SINGULAR",
        "reduction/basis.py: left > HELD",
        "reduction/basis.py: np.linalg.eigvalsh(K_a)[0] <= 1e-12",
        "reduction/checks.py: np.linalg.eigvalsh(_unit_diagonal(rigid_mass)).min(initial=1.0) < 1e-12",
        "reduction/checks.py: ratio[worst] > _GROUNDED",
        "reduction/statics.py: self.factor.weakest_pivot > 1e-09",
        "reduction/subspace.py: np.abs(length - 1.0) < 1e-06",
        "reduction/transfer_error.py: max(damping, 0.0001)",
        "system/alike.py: np.abs(moved * system.units) > ROUND",
        "system/alike.py: np.linalg.svd(A / norms[:, None], compute_uv=False)[-1] > REGULAR",
        "system/alike.py: np.linalg.svd(scaled, compute_uv=False)[:, -1].min() > HEAVY",
        "system/assembly.py: shares > OPEN_RATE",
        "system/complaints.py: np.linalg.svd(own / np.sqrt(np.outer(diagonal, diagonal)), compute_uv=False)[-1] > ZERO",
        "system/lengths.py: lost[k] <= LOST",
        "system/projection.py: stride <= EXACT",
        "system/massless.py: held.min() <= HELD",
        "system/massless.py: np.linalg.svd(scaled, compute_uv=False)[:, -1] > SINGULAR",
        "system/mobility.py: shares > SHARE",
        "tree/any_body/joint_basis.py: length > 1e-12",
        "tree/any_body/light_points.py: mass * usual < LIGHT",
        "tree/coordinates/reach.py: max(damping * 0.1, LEAST)",
        "tree/flexible/closing.py: max(RANK * min(most, 1.0), ROUNDING)",
        "tree/rigid/closing.py: max(RANK * min(most, 1.0), ROUNDING)",
        "trust/settings.py: max(LEAST, TENTH * value)",
        "trust/settings.py: max(LEAST, getattr(integrator, 'rtol', 1e-06))",
        "trust/settings.py: min(rtol, 1e-06)",
    ),
}
"""Family: file and expression."""


ASSIGNED = re.compile(r"^\w.*=.*(?:[0-9]e-|0\.00)", re.MULTILINE)
"""A file without such a line has no constants that are small."""


class Read(NamedTuple):
    """What is asked of a file: the names of its small numbers, its comparisons, calls and imports."""

    constants: set[str]
    nodes: list[ast.Compare | ast.Call | ast.ImportFrom]


@lru_cache(maxsize=1)
def _read(text: str) -> Read:
    """Return what is asked of a file by one walk, which takes most of the time."""
    tree = ast.parse(text)
    asked = ast.Compare | ast.Call | ast.ImportFrom
    return Read(_constants(tree), [node for node in ast.walk(tree) if isinstance(node, asked)])


def _small(node: ast.expr) -> bool:
    node = node.operand if isinstance(node, ast.UnaryOp) else node
    return isinstance(node, ast.Constant) and isinstance(node.value, float) and TINY < abs(node.value) <= SMALL


def _written(node: ast.expr) -> str:
    """Return a name, alone or after modules, as it is written, and nothing of what is not one."""
    if isinstance(node, ast.Attribute):
        before = _written(node.value)
        return before and f"{before}.{node.attr}"
    return node.id if isinstance(node, ast.Name) else ""


def _constants(tree: ast.Module) -> set[str]:
    """Return the names of the small numbers of a file."""
    found = set()
    for statement in tree.body:
        if isinstance(statement, ast.Assign):
            for target in statement.targets:
                names = target.elts if isinstance(target, ast.Tuple) else [target]
                values = statement.value.elts if isinstance(statement.value, ast.Tuple) else [statement.value]
                if len(names) == len(values):
                    found |= {n.id for n, v in zip(names, values) if isinstance(n, ast.Name) and _small(v)}
    return found


def _imported(read: Read, small: dict[str, set[str]]) -> set[str]:
    """Return the small numbers of other files, by module in `small`, as a file writes them: alone or after a module."""
    found = set()
    for node in read.nodes:
        if isinstance(node, ast.ImportFrom):
            for one in node.names:
                name = one.asname or one.name
                found |= {name} if one.name in small.get(str(node.module), ()) else set()
                found |= {f"{name}.{constant}" for constant in small.get(f"{node.module}.{one.name}", ())}
    return found


def bare_thresholds(text: str, small: dict[str, set[str]] | None = None) -> list[str]:
    """Return the comparisons with a small number that nothing multiplies, as min and max are ones."""
    read = _read(text)
    names = read.constants | _imported(read, small or {})
    found = []
    for node in read.nodes:
        compared: list[ast.expr] = []
        if isinstance(node, ast.Compare):
            compared = [node.left, *node.comparators]
        elif isinstance(node, ast.Call) and _written(node.func) in ("max", "min", "np.maximum", "np.minimum"):
            compared = node.args
        if any(_small(one) or _written(one) in names for one in compared):
            found.append(ast.unparse(node))
    return found


def hidden_thresholds(text: str) -> list[str]:
    """Return the comparisons by numpy whose absolute part is a number as it stands; left out it is 1e-8 of any unit."""
    found = []
    for node in _read(text).nodes:
        if isinstance(node, ast.Call) and _written(node.func) in ("np.allclose", "np.isclose"):
            given = [word.value for word in node.keywords if word.arg == "atol"]
            if not given or _small(given[0]):
                found.append(ast.unparse(node))
    return found


def test_the_search_finds_them():
    text = "SAME = 1e-9\nif gap < SAME or gap < SAME * size or max(gap, 1e-6) > 0.5 or gap < 1e-300: pass"
    assert bare_thresholds(text) == ["gap < SAME", "max(gap, 1e-06)"]
    others = "from flexmb.a import SAME as S, LARGE\nfrom flexmb import a\n"
    others += "if x < S or x < a.SAME or x < LARGE or x < S * y: pass"
    assert bare_thresholds(others, {"flexmb.a": {"SAME"}}) == ["x < S", "x < a.SAME"]
    hidden = "np.allclose(J, J.T) or np.isclose(a, b, atol=1e-9) or np.allclose(a, b, atol=1e-9 * size)"
    assert hidden_thresholds(hidden) == ["np.allclose(J, J.T)", "np.isclose(a, b, atol=1e-09)"]


def test_every_bare_threshold_is_known():
    known = {entry for family in KNOWN.values() for entry in family}
    texts = {path.relative_to(ROOT): path.read_text("utf-8") for path in ROOT.rglob("*.py")}
    small = {
        ".".join(("flexmb", *path.with_suffix("").parts)): _constants(ast.parse(text))
        for path, text in texts.items()
        if ASSIGNED.search(text)
    }
    found = {
        f"{path.as_posix()}: {threshold}"
        for path, text in texts.items()
        for threshold in (*bare_thresholds(text, small), *hidden_thresholds(text))
    }
    new = sorted(found - known)
    assert not new, "compare with something of the same unit, or add it to its family here: " + "; ".join(new)
    assert not known - found, "gone; take it out here: " + "; ".join(sorted(known - found))
