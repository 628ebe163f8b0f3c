"""`Simulation`: what the table ``[simulation]`` of a model file asks for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from flexmb.errors import ModelError
from flexmb.model.described import Described, is_number
from flexmb.model.methods import is_integrator, require_time_limit
from flexmb.results.phase import MOST_SAMPLES

__all__ = ["Simulation"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Simulation(metaclass=Described):
    """How a model is simulated: ``flexmb.simulate(model, **settings.keywords())``.

    Parameters
    ----------
    t_end : float, s
    samples : int, optional
        Number of equally spaced samples, both ends included.
    integrator : integrator, optional
        In a file: ``integrator = {kind = "GeneralizedAlpha", rho_inf = 0.8}``.
    start : "equilibrium", optional
        Begin in equilibrium with the loads of the start, instead of as described.
    time_limit : float, s, optional
        Clock time after which the run ends with what it has reached; see `flexmb.simulate`.
    """

    t_end: float
    samples: int | None = None
    integrator: Any = None
    start: str | None = None
    time_limit: float | None = None

    def __post_init__(self):
        t_end, samples = self.t_end, self.samples
        if not is_number(t_end) or t_end <= 0.0:
            raise ModelError(
                "Simulation",
                found=f"t_end = {t_end!r}",
                expected="a positive duration in s",
                remedy="Write t_end = 1.0",
            )
        if samples is not None and (
            not is_number(samples) or samples != int(samples) or not 2 <= samples <= MOST_SAMPLES
        ):
            raise ModelError(
                "Simulation",
                found=f"samples = {samples!r}",
                expected=f"a whole number of at least 2 and at most {MOST_SAMPLES}",
                remedy="Write samples = 1001",
            )
        if self.integrator is not None and not is_integrator(self.integrator):
            raise ModelError(
                "Simulation",
                found=f"integrator = {self.integrator!r}",
                expected="an integrator such as GeneralizedAlpha(rho_inf=0.8)",
                remedy='In a file write integrator = { kind = "GeneralizedAlpha", rho_inf = 0.8 }',
            )
        if self.start not in (None, "equilibrium"):
            raise ModelError(
                "Simulation",
                found=f"start = {self.start!r}",
                expected='"equilibrium"',
                remedy="Leave it out to begin as described",
            )
        require_time_limit(self.time_limit, "Simulation")
        object.__setattr__(self, "t_end", float(t_end))
        object.__setattr__(self, "samples", None if samples is None else int(samples))

    def keywords(self) -> dict[str, Any]:
        """Return the settings that are given, by name."""
        return {name: value for name, value in vars(self).items() if value is not None}
