"""The drive of the flap transmission as a control loop: position loop, torque limiter and brake, built of blocks.

    wanted angle --(+)--> k e + c e' --> limiter --> released? --> (+)--> PCU --> shafts, stations 1 to 5, loads
                    ^                                                ^      |
                    |                    brake: bristles, engaged? --+      |
                    +-------------------------------------------------------+ angle and speed of the PCU

`transmission.toml` turns the PCU by a `Motor`. Here a formula of the wanted and of the measured angle, a `Limit` at the
stall torque of 250 N m and an `Actuator` do so, and a brake: a `Relay` releases it when the wanted or the real speed
passes 2 rad/s and engages it below 1 rad/s. Engaged, it holds the shaft by bristles, whose deflection is the state of
an `Integral` (Dahl's friction), and the motor is without current.

Two claims are computed: while the brake is released, the loop moves the PCU as the `Motor` does; engaged, the brake
carries what the loads of the stations ask for, torque over gear ratio, and the shaft creeps no further.
"""

from pathlib import Path

import numpy as np

import flexmb as fmb

FOLDER = Path(__file__).parent
STATIONS = range(1, 6)
LOAD = 12.0
"""Torque against the extension at the input of each actuator, N m."""
BRAKE_STIFFNESS, BRAKE_DAMPING, BRAKE_TORQUE = 2e4, 40.0, 300.0
"""Of the brake: N m/rad, N m s/rad, N m; assumed."""


def loaded(turn_time: float, load: float = LOAD) -> fmb.Model:
    """Return the transmission with a load on every station, its PCU turned by a `Motor`."""
    model = fmb.load_model(FOLDER / "transmission.toml", {"variant": 1, "turn_time": turn_time})
    rising = fmb.step(value=-load, rise=0.2)
    return model.with_parts(
        forces=[fmb.Actuator(f"load {k}", joint=f"s{k}_input", effort=rising) for k in STATIONS],
        sensors=[fmb.Velocity("pcu speed", marker="pcu.axis")],
    )


def with_loop(model: fmb.Model) -> fmb.Model:
    """Return the model with the `Motor` replaced by position loop, limiter and brake."""
    motor, angle = model.force("motor"), fmb.JointCoordinate("x", joint="pcu")
    both = {"s": motor.target, "x": angle}
    error = fmb.formula("k*(s - x) + c*(rate(s) - rate(x))", over=both, k=motor.stiffness, c=motor.damping)
    limited = fmb.Limit(error, limits=motor.limits)
    moving = fmb.formula("abs(rate(s)) + abs(rate(x))", over=both)
    released = fmb.Relay(moving, limits=(1.0, 2.0), values=(0.0, 1.0), on=False, name="brake")
    # engaged, bristles bend with the shaft until they slip; released, they straighten
    bend = fmb.formula(
        "(1 - r)*rate(x) - r*z/T",
        over={"r": released, "x": angle, "z": fmb.State("z", of="bristles")},
        T=0.01,
    )
    reach = BRAKE_TORQUE / BRAKE_STIFFNESS
    bristles = fmb.Integral(bend, limits=(-reach, reach), tracking=1e-3, size=reach, name="bristles")
    brake = fmb.formula(
        "-(1 - r)*(k*z + c*rate(x))",
        over={"r": released, "z": bristles, "x": angle},
        k=BRAKE_STIFFNESS,
        c=BRAKE_DAMPING,
    )
    drive = fmb.formula("r*u", over={"r": released, "u": limited})
    return model.without("motor", "pcu torque").with_parts(
        forces=[
            fmb.Actuator("motor", joint="pcu", effort=drive),
            fmb.Actuator("brake torque", joint="pcu", effort=brake),
        ],
        sensors=[
            fmb.SignalValue("released", of=released),
            fmb.SignalValue("motor torque", of=drive),
            fmb.SignalValue("brake", of=brake),
        ],
    )


def extension(model: fmb.Model, turn_time: float, rest: float = 1.0) -> fmb.Solution:
    """Return a run over the travel, and a rest behind it."""
    end = turn_time + rest
    return fmb.simulate(
        model, t_end=end, samples=round(100 * end) + 1, integrator=fmb.GeneralizedAlpha(rtol=1e-6, largest=0.01)
    )


def main(turn_time: float = 6.0) -> dict[str, float]:
    """Return what the loop and the `Motor` differ by, and what the brake holds."""
    plain = loaded(turn_time)
    motor, loop = extension(plain, turn_time), extension(with_loop(plain), turn_time)
    ratio = motor["pcu angle"][-1] / motor["s3_input angle"][-1]
    free = (loop["released"] > 0.5) & (loop.t > 0.5)
    return {
        "difference": float(np.abs(loop["pcu angle"] - motor["pcu angle"])[free].max(initial=0.0)),
        "travel": float(motor["pcu angle"][-1]),
        "torque": float(np.interp(0.5 * turn_time, loop.t, loop["motor torque"])),
        "loads": float(5 * LOAD / ratio),
        "brake": float(loop["brake"][-1]),
        "creep": float(np.ptp(loop["pcu angle"][-51:])),
        "engaged": float(loop.t[loop["released"] > 0.5].max(initial=0.0)),
    }


if __name__ == "__main__":
    found = main()
    print("PCU turns {travel:.3f} rad; loop and motor differ by {difference:.2e} rad".format(**found))
    print("motor {torque:.3f} N m at half travel, brake {brake:.3f} N m, loads {loads:.3f} N m".format(**found))
    print("brake engaged at {engaged:.3f} s, creep {creep:.1e} rad".format(**found))
