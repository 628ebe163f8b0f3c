"""Torsion constants and shear factors of the section library.

Shear factors: G. R. Cowper, The shear coefficient in Timoshenko's beam theory, J. Appl. Mech. 33 (1966)
335-340, table 1.
"""

from __future__ import annotations

from math import pi, tanh

__all__ = [
    "cowper_box",
    "cowper_hollow_circle",
    "cowper_i",
    "cowper_rectangle",
    "torsion_box",
    "torsion_i",
    "torsion_rectangle",
]


def torsion_rectangle(width: float, height: float) -> float:
    """Return St-Venant's torsion constant (m4) of a solid rectangle, sides in m.

    ``J = a b^3 / 3 (1 - 192 b / (pi^5 a) sum_n tanh(n pi a / 2 b) / n^5)``, n = 1, 3, 5, ..., a >= b
    (Timoshenko & Goodier, Theory of Elasticity, art. 109). Forty terms leave 1e-10.
    """
    a, b = max(width, height), min(width, height)
    if b <= 0.0:
        return 0.0  # `Section` says what is wrong
    series = sum(tanh(min(n * pi * a / (2 * b), 300.0)) / n**5 for n in range(1, 80, 2))
    return a * b**3 / 3.0 * (1.0 - 192.0 * b / (pi**5 * a) * series)


def torsion_box(width: float, height: float, flange: float, web: float) -> float:
    """Return the torsion constant (m4) of a box; width and height (m) between the middle lines of the walls.

    Bredt's closed cell ``4 A_m^2 / oint ds / t`` plus the open part ``oint t^3 ds / 3`` of the walls.
    """
    cell = 4.0 * (width * height) ** 2 / (2.0 * width / flange + 2.0 * height / web)
    return cell + 2.0 * (width * flange**3 + height * web**3) / 3.0


def torsion_i(width: float, height: float, flange: float, web: float) -> float:
    """Return the torsion constant (m4) of an I without fillets (m).

    El Darwish & Johnston, Torsion of structural shapes, ASCE J. Struct. Div. 91 ST1 (1965) 203-227: the three
    rectangles, the loss at the four flange tips and the gain at the two junctions.
    """
    ratio = web / flange
    junction = -0.042 + 0.2204 * ratio - 0.0725 * ratio**2
    inscribed = flange + web**2 / (4.0 * flange)
    walls = 2.0 * width * flange**3 / 3.0 + (height - 2.0 * flange) * web**3 / 3.0
    return walls + 2.0 * junction * inscribed**4 - 0.42 * flange**4


def cowper_rectangle(poisson: float) -> float:
    """Return Cowper's shear factor of a solid rectangle; 5/6 for poisson = 0."""
    return 10.0 * (1.0 + poisson) / (12.0 + 11.0 * poisson)


def cowper_hollow_circle(ratio: float, poisson: float) -> float:
    """Return Cowper's shear factor of a hollow circle, ratio = inner / outer diameter; 0 is the solid
    circle."""
    square = (1.0 + ratio**2) ** 2
    return 6.0 * (1.0 + poisson) * square / ((7.0 + 6.0 * poisson) * square + (20.0 + 12.0 * poisson) * ratio**2)


def cowper_box(width: float, height: float, flange: float, web: float, poisson: float) -> float:
    """Return Cowper's shear factor of a thin-walled box, force along the height (m, middle lines)."""
    m, n = width * flange / (height * web), width / height
    return _cowper_numerator(m, poisson) / (
        _cowper_walls(m, poisson) + 10.0 * n**2 * ((3.0 + poisson) * m + 3.0 * m**2)
    )


def cowper_i(width: float, height: float, flange: float, web: float, poisson: float) -> float:
    """Return Cowper's shear factor of a thin-walled I, force along the web (m, middle lines)."""
    m, n = 2.0 * width * flange / (height * web), width / height
    flanges = 30.0 * n**2 * (m + m**2) + 5.0 * poisson * n**2 * (8.0 * m + 9.0 * m**2)
    return _cowper_numerator(m, poisson) / (_cowper_walls(m, poisson) + flanges)


def _cowper_numerator(m: float, poisson: float) -> float:
    return 10.0 * (1.0 + poisson) * (1.0 + 3.0 * m) ** 2


def _cowper_walls(m: float, poisson: float) -> float:
    return 12.0 + 72.0 * m + 150.0 * m**2 + 90.0 * m**3 + poisson * (11.0 + 66.0 * m + 135.0 * m**2 + 90.0 * m**3)
