"""The six-axis arm PUMA 560 from its Denavit-Hartenberg table.

Problem: where is the hand, which torques hold the arm against gravity, and which angles bring the hand somewhere else?

Formula: T = product of R_z(theta) T_z(d) T_x(a) R_x(alpha); torques by recursive inverse dynamics.
Data: Corke & Armstrong-Helouvry 1994, masses of the links without motors. The tensors of links 1 and 3, which no body
can have, are replaced by possible ones; at rest they have no effect.
Expected at the angles (0, 45, 180, 0, 45, 0) degrees: hand at ((2 0.4318 - 0.0203) / sqrt 2, -0.15005, -0.0203 / sqrt
2) = (0.5963, -0.1501, -0.01435) m, upper arm and forearm being as long; torques 31.6399, 6.0351, 0.0283 N m in joints
2, 3, 5 (Corke & Haviland, Robotics Toolbox for Python, tests/test_DHRobot.py, gravload of the nominal pose).
"""

import numpy as np

import flexmb as fmb

RIGHT = np.pi / 2
#        a (m)   d (m)    alpha   mass   centre of mass (m)            inertia (kg m2)
TABLE = [
    (0.0, 0.0, RIGHT, 1.0, (0, 0, 0), (0.35, 0.35, 0.35)),
    (0.4318, 0.0, 0.0, 17.4, (-0.3638, 0.006, 0.2275), (0.13, 0.524, 0.539)),
    (0.0203, 0.15005, -RIGHT, 4.8, (-0.0203, -0.0141, 0.070), (0.066, 0.0785, 0.0125)),
    (0.0, 0.4318, RIGHT, 0.82, (0, 0.019, 0), (1.8e-3, 1.3e-3, 1.8e-3)),
    (0.0, 0.0, -RIGHT, 0.34, (0, 0, 0), (0.3e-3, 0.4e-3, 0.3e-3)),
    (0.0, 0.0, 0.0, 0.09, (0, 0, 0.032), (0.15e-3, 0.15e-3, 0.04e-3)),
]
NOMINAL = np.radians([0, 45, 180, 0, 45, 0])


def arm():
    """Return the model."""
    links = [
        fmb.StandardLink(a=a, d=d, alpha=alpha, mass=m, center_of_mass=c, inertia=J) for a, d, alpha, m, c, J in TABLE
    ]
    return fmb.serial_arm(links, gravity=(0, 0, -9.81), name="PUMA 560")


def main():
    """Return position of the hand (m) and holding torques (N m), one after the other."""
    tree = fmb.JointTree(arm())
    hand, axes = tree.pose("link_6.tool", NOMINAL)
    torques = tree.torques(NOMINAL)
    print("hand at", hand.round(5), "m; holding torques", torques.round(4), "N m")
    aim = fmb.Pose(hand + (-0.05, 0.2, 0.1), axes)
    angles = tree.reach("link_6.tool", aim, start=NOMINAL)
    print("0.2 m aside and 0.1 m higher, angles in degrees:", np.degrees(angles).round(2))
    return np.concatenate([hand, torques])


if __name__ == "__main__":
    main()
