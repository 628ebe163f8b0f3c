"""The geometry of a pair of involute gears in the transverse plane, and the stiffness of its teeth by ISO 6336-1.

Numbers of teeth inside a ring count as negative, so that one set of formulas serves outer and inner pairs (DIN 3960).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

__all__ = ["ToothGeometry", "iso_range", "single_stiffness"]

STEEL = 206e9
"""Pa, modulus of elasticity to which ISO 6336-1 refers."""


def involute(angle: float) -> float:
    """Return tan(angle) - angle."""
    return float(np.tan(angle) - angle)


@dataclass(frozen=True)
class ToothGeometry:
    """A pair of gears; lengths in m, angles in rad, teeth of a ring negative."""

    module: float
    teeth: tuple[int, int]
    pressure_angle: float
    helix: float
    shifts: tuple[float, float]
    addendum: float
    thinning: float
    distance: float
    """of the axes, positive"""

    @property
    def transverse_angle(self) -> float:
        """Pressure angle in the transverse plane at the reference circles."""
        return float(np.arctan(np.tan(self.pressure_angle) / np.cos(self.helix)))

    @property
    def radii(self) -> tuple[float, float]:
        """Reference radii."""
        a, b = (0.5 * self.module / np.cos(self.helix) * z for z in self.teeth)
        return float(a), float(b)

    @property
    def base_radii(self) -> tuple[float, float]:
        """Radii of the base circles."""
        a, b = self.radii
        return a * float(np.cos(self.transverse_angle)), b * float(np.cos(self.transverse_angle))

    @property
    def tip_radii(self) -> tuple[float, float]:
        """Radii of the tip circles; of a ring negative."""
        a, b = (r + self.module * (x + self.addendum) for r, x in zip(self.radii, self.shifts))
        return float(a), float(b)

    @property
    def pitch(self) -> float:
        """Transverse base pitch."""
        return 2.0 * np.pi * self.base_radii[0] / self.teeth[0]

    @property
    def base_helix(self) -> float:
        """Helix angle on the base cylinders."""
        return float(np.arcsin(np.sin(self.helix) * np.cos(self.pressure_angle)))

    @property
    def side(self) -> float:
        """1 for an outer pair, -1 inside a ring."""
        return 1.0 if self.teeth[1] > 0 else -1.0

    @property
    def working_angle(self) -> float:
        """Transverse pressure angle at the distance of the axes; nan if the base circles overlap."""
        cosine = sum(self.base_radii) / (self.side * self.distance) if self.distance > 0.0 else np.inf
        return float(np.arccos(cosine)) if 0.0 < cosine < 1.0 else float("nan")

    @property
    def tight(self) -> float:
        """r inv alpha at which both flanks of a tooth touch: eq. (gear-gap)."""
        thickness = sum(self.shifts) * self.module * np.tan(self.pressure_angle) / np.cos(self.helix)
        thickness -= 0.5 * self.thinning
        a_t = self.transverse_angle
        return float(sum(self.base_radii) * involute(a_t) + np.cos(a_t) * thickness)

    @property
    def play(self) -> float:
        """Play along the line of action in the transverse plane."""
        return 2.0 * (sum(self.base_radii) * involute(self.working_angle) - self.tight)

    @property
    def tight_distance(self) -> float:
        """Distance of the axes without play."""
        total = sum(self.base_radii)
        wanted = self.tight / total
        low, high = 0.0, 1.5
        for _ in range(100):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if involute(middle) < wanted else (low, middle)
        return float(abs(total) / np.cos(low))

    @property
    def path(self) -> tuple[float, float]:
        """First and last place of contact on the line of action, from the tangent point of the first base circle."""
        ends = [np.sign(b) * max(t * t - b * b, 0.0) ** 0.5 for t, b in zip(self.tip_radii, self.base_radii)]
        along = self.side * self.distance * np.sin(self.working_angle)
        return float(along - ends[1]), float(ends[0])

    @property
    def contact_ratio(self) -> float:
        """Transverse contact ratio: length of the path of contact over the base pitch."""
        first, last = self.path
        return (last - first) / self.pitch

    @property
    def half_tooth(self) -> float:
        """Half the angle of a tooth of the first gear on its base circle."""
        thickness = self.module / np.cos(self.helix) * 0.5 * np.pi - 0.5 * self.thinning
        thickness += 2.0 * self.shifts[0] * self.module * np.tan(self.pressure_angle) / np.cos(self.helix)
        return float(0.5 * thickness / self.radii[0] + involute(self.transverse_angle))


def iso_range(geometry: ToothGeometry) -> str:
    """Return what of a pair is outside the range of the single stiffness of ISO 6336-1, method B; "" if nothing is."""
    small, large = geometry.shifts
    if geometry.side > 0 and geometry.teeth[0] > geometry.teeth[1]:
        small, large = large, small
    if small < large:
        return f"a pinion with a smaller profile shift ({small:g}) than the wheel ({large:g})"
    if not -0.5 <= small + large <= 2.0:
        return f"a sum of profile shifts of {small + large:g}, outside -0.5 to 2"
    if geometry.contact_ratio < 1.2:
        return f"a transverse contact ratio of {geometry.contact_ratio:.4g}, below 1.2"
    if abs(geometry.helix) > np.pi / 4.0:
        return f"a helix of {np.degrees(geometry.helix):.4g} degrees, above 45"
    return ""


def single_stiffness(geometry: ToothGeometry, dedendum: float, young: float) -> float:
    """Return the single stiffness c' of a pair of teeth, N/m2 (force per width and deflection), of solid gears.

    ``1/q' cos(helix) C_M C_B E/E_St`` with q' = C1 + ... C9 (ISO 6336-1:2006, eqs. 82 to 88, table 9), C_M = 0.8, for
    line loads of at least 100 N/mm.
    """
    z1, z2, x1, x2 = *geometry.teeth, *geometry.shifts
    if z2 > 0 and z1 > z2:
        z1, z2, x1, x2 = z2, z1, x2, x1
    virtual = np.cos(geometry.helix) ** 3
    n1, n2 = virtual / z1, virtual / z2 if z2 > 0 else 0.0  # 1/z_n; a ring counts as a rack
    q = 0.04723 + 0.15551 * n1 + 0.25791 * n2 - 0.00635 * x1 - 0.11654 * x1 * n1
    q += -0.00193 * x2 - 0.24188 * x2 * n2 + 0.00529 * x1**2 + 0.00182 * x2**2
    basic = (1.0 + 0.5 * (1.2 - dedendum)) * (1.0 - 0.02 * (20.0 - np.degrees(geometry.pressure_angle)))
    return float(1e9 / q * 0.8 * basic * np.cos(geometry.helix) * young / STEEL)  # N/(mm um) is 1e9 N/m2
