"""The laws of contacts between surfaces: objects of a `SurfaceContact`."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import ClassVar

from flexmb.errors import ModelError
from flexmb.model.described import Described, is_number

__all__ = ["ContactLaw", "ElasticFoundation", "Hertz"]


@dataclass(frozen=True, eq=False)
class ContactLaw(metaclass=Described):
    """What two surfaces do to each other where they touch."""

    code: ClassVar[int] = -1
    """Its number in the rows of `SurfaceContact`; from 2 on the law is not compliant, and the force's kernel idle."""
    impulsive: ClassVar[bool] = False
    """Does it stop bodies at once, by impulses?"""
    sampled: ClassVar[bool] = False
    """Does it act on areas, so that a surface must be sampled?"""

    def _require(self, *names: str, zero: bool = False) -> None:
        for name in names:
            value = getattr(self, name)
            if not is_number(value) or value < 0.0 or (value == 0.0 and not zero):
                raise ModelError(
                    type(self).__name__,
                    found=f"{name} = {value!r}",
                    expected="a number " + (">= 0" if zero else "> 0") + " in SI units",
                    remedy=f"Give {name} a value in N, m, s",
                )

    def numbers(self) -> dict[str, float]:
        """Return stiffness, exponent, damping, friction, transition and restitution of the row."""
        raise TypeError(f"{type(self).__name__} has no numbers")


@dataclass(frozen=True, eq=False)
class _Compliant(ContactLaw):
    """What compliant laws share."""

    _: KW_ONLY
    damping: float = 0.0
    friction: float = 0.0
    transition: float = 1e-3

    def __post_init__(self):
        self._require("transition")
        self._require("damping", "friction", zero=True)

    def _shared(self, stiffness: float, exponent: float) -> dict[str, float]:
        return {
            "stiffness": stiffness,
            "exponent": exponent,
            "damping": self.damping,
            "friction": self.friction,
            "transition": self.transition,
            "restitution": 0.0,
        }


@dataclass(frozen=True, eq=False)
class ElasticFoundation(_Compliant):
    """An elastic layer between rigid surfaces, eq. (elastic-foundation): pressure ``p = K/h u (1 + D u')``.

    Each point of the sampled surface is a spring of its own, so the pressure depends on the penetration u there alone.
    For a layer of linear material bonded to a stiff back, and thin compared with the contact, K is the modulus of
    compression without side strain, ``E (1 - nu) / ((1 + nu) (1 - 2 nu))``. It is not the law of Hertz: see the theory.

    Parameters
    ----------
    modulus : float, Pa
        K.
    thickness : float, m
        h, of both layers together if both bodies have one.
    damping : float, s/m
        D of Hunt and Crossley; `Contact.damping_for(e, v)` for a restitution e at the speed v.
    friction : float, -
        Of Coulomb, regularised: full at slips well above `transition`.
    transition : float, m/s
        Slip at which friction has reached 71 % of its full size.

    Source: Johnson, Contact Mechanics, section 4.3; Hunt & Crossley 1975, eq. 12.
    """

    modulus: float
    thickness: float

    code: ClassVar[int] = 0
    sampled: ClassVar[bool] = True

    def __post_init__(self):
        super().__post_init__()
        self._require("modulus", "thickness")

    def numbers(self) -> dict[str, float]:
        """Return the numbers of the row."""
        return self._shared(self.modulus / self.thickness, 1.0)


@dataclass(frozen=True, eq=False)
class Hertz(_Compliant):
    """The contact of a ball with a smooth surface: ``f = k u^1.5 (1 + D u')``, eq. (contact).

    Parameters
    ----------
    stiffness : float, N/m^1.5
        k of the pair, `Contact.hertz_stiffness(radius, material, other_radius, other_material)`.
    damping : float, s/m
        D of Hunt and Crossley; `Contact.damping_for(e, v)` for a restitution e at the speed v.
    friction : float, -
    transition : float, m/s
        Slip at which friction has reached 71 % of its full size.

    Source: Johnson, Contact Mechanics, section 4.2; Hunt & Crossley 1975, eq. 12.
    """

    stiffness: float

    code: ClassVar[int] = 1

    def __post_init__(self):
        super().__post_init__()
        self._require("stiffness")

    def numbers(self) -> dict[str, float]:
        """Return the numbers of the row."""
        return self._shared(self.stiffness, 1.5)
