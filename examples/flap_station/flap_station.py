"""Flap station of a transport aircraft: how far does the flap dip before it turns down?

      nose .___________________________ TE     A actuator, lever A-D 0.60 m (elastic, 24 kg titanium, 9880 nodes)
           \\__ F       R ______________/       D-E drive strut 1.30 m, E and F on the carriage, rail 14 deg
    A o     o==========o                       R-P pendulum 0.75 m
      |\\  E/  rail      \\
      | \\_/ strut        o P                   airload: 0.756 of the inboard flap's, 67 kN at landing

The lever turns by 117 deg. Carriage stroke s and flap angle theta follow from the two loops of the rigid linkage,

    |F + s t + e - A - l d(phi)| = 1.30 m,      |F + s t + R(theta) (r - f) - P| = 0.75 m:

retracted 0 deg, then the nose-up dip of -2.47 deg, 0 deg again at 0.52 of the travel, and 38.0 deg at the end. The
elastic lever gives way to the airload by 2 mm and leaves 37.9 deg. Expected number: the dip, -2.47 deg.

Run it with: python examples/flap_station/flap_station.py (or flexmb demo, which writes pictures and ParaView files)
"""

from importlib.resources import as_file, files

import numpy as np

import flexmb as fmb


def main() -> float:
    """Return the least flap angle, deg."""
    with as_file(files("flexmb") / "cli" / "demo_data") as folder:  # the model file and its mesh
        model = fmb.load_model(folder / "flap_station.toml")
    print(fmb.check(model))
    solution = fmb.simulate(model, t_end=1.0, samples=201, start="equilibrium")
    angle = np.degrees(solution["flap angle"])
    print(f"flap angle: dip {angle.min():.3f} deg, landing {angle[-1]:.2f} deg")
    print(f"drive strut: {solution['strut force'][:, 0].min() / 1e3:.1f} kN at most")
    print(f"lever: {solution['lever stress'].max() / 1e6:.0f} MPa at most")
    return float(angle.min())


if __name__ == "__main__":
    main()
