"""One page with Figs. 16 to 23 of Zierath, Woernle & Heyden: flaps, droop nose and slats, before and after failures.

Run it with: python examples/highlift/report.py [elastic] [page.html]   (five runs; elastic: some minutes)
"""

import sys
from pathlib import Path

import flexmb as fmb
from flexmb.view import Diagram

FOLDER = Path(__file__).parent
CASES = {
    "operation": ("operation", 1.0),
    "strut 2 breaks": ("strut_2_breaks", 1.8),
    "nose": ("droop_operation", 1.0),
    "strut E breaks": ("droop_strut_breaks", 1.8),
    "slats": ("slats", 1.0),
}
"""Name of a run: model file, time at which it ends (s)."""
ONE, TWO = "inboard_t1_strut force fx", "inboard_t2_strut force fx"
BEFORE = f"{ONE} at 0.645"
STRUT = "interconnection strut"
BOTH = ["operation", "strut 2 breaks"]
AFTER = (0.5, 1.8)
LABELS = {
    "track 1": "inboard_t1_strut",
    "track 2": "inboard_t2_track",
    **{f"track {k}": f"outboard_t{k}_track" for k in (3, 4, 5)},
    "interconnection strut": "casing",
    **{f"arm {k}": f"s{k}_arm" for k in (1, 2, 3, 4, 5)},
    **{f"slat {k}": f"s{k}_beam" for k in (1, 2, 3, 4, 5, 6)},
}
"""Texts in the pictures, and the bodies at whose middle they are."""
FLAPS = {
    False: {"inboard flap": "inboard_flap_tip", "outboard flap": "outboard_flap_mid", "droop nose": "nose_inner"},
    True: {"inboard flap": "inboard_flap_beam", "outboard flap": "outboard_flap_beam", "droop nose": "nose_beam"},
}
"""The same of flaps and nose, by whether they are elastic."""
CAMERAS = dict.fromkeys(("nose", "strut E breaks"), (0.3, 1.0, 0.5))  # from outboard, into the nose
HIDDEN = ("springs",)
"""Bushings and stops, which would stand before the parts that they hold."""
FIGURES = (
    Diagram(
        title="Fig. 16: flaps and actuators",
        y=[
            f"{station} angle"
            for flap in ("inboard_t2", "outboard_t4")
            for station in (f"{flap}_flap", f"{flap}_lever")
        ],
        of=["operation"],
    ),
    Diagram(title=f"Fig. 17: {STRUT}, relative motion", y=["interconnection travel"], of=["operation"]),
    Diagram(
        title="Fig. 18: drive struts over strut 1 at 0.645 s",
        y=[ONE, TWO],
        per=BEFORE,
        of=["operation"],
        scale="struts",
    ),
    Diagram(
        title="Fig. 19: the same, strut 2 breaks",
        y=[ONE, TWO],
        per=BEFORE,
        of=["strut 2 breaks"],
        scale="struts",
        limits=AFTER,
    ),
    Diagram(title=f"Fig. 20: {STRUT}, relative motion", y=["interconnection travel"], of=BOTH, limits=AFTER),
    Diagram(
        title=f"Fig. 21: force of the {STRUT} over strut 1 at 0.645 s",
        y=["interconnection force fz"],
        per=BEFORE,
        of=BOTH,
        limits=AFTER,
    ),
    Diagram(
        title="Fig. 22: angles of droop nose and slat",
        y=["s2_nose angle", "s1_angle value"],
        per="final",
        of=["nose", "slats"],
    ),
    Diagram(
        title="Fig. 23: drive struts of the droop nose over strut 2 at 0.7 s",
        y=["s2_drive strut force fx", "s4_drive strut force fx"],
        per="s2_drive strut force fx at 0.7",
        of=["nose", "strut E breaks"],
        limits=AFTER,
    ),
)


def run(case: str, t_end: float, elastic: bool) -> fmb.Solution:
    """Return the solution of a case, 500 samples a second."""
    path, given = FOLDER / f"{case}.toml", {"rigid": not elastic}
    settings = fmb.load_simulation(path, given, t_end=t_end, samples=round(500 * t_end) + 1)
    return fmb.simulate(fmb.load_model(path, given), **settings.keywords())


def main(elastic: bool = False, page: str = "high_lift.html", pictures: bool = True) -> dict[str, fmb.Solution]:
    """Write the page, and the figures beside it as a picture; return the runs."""
    runs = {name: run(case, t_end, elastic) for name, (case, t_end) in CASES.items()}
    labels = LABELS | FLAPS[elastic]
    fmb.view.report(runs, page, diagrams=FIGURES, pictures=pictures, labels=labels, camera=CAMERAS, hide=HIDDEN)
    fmb.view.draw_diagrams(runs, FIGURES, Path(page).with_suffix(".png"), columns=2)
    return runs


if __name__ == "__main__":
    words = sys.argv[1:]
    main("elastic" in words, next((word for word in words if word.endswith(".html")), "high_lift.html"))
