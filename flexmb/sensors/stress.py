"""`Stress`: stress of a flexible body at a node, or the largest in a region."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np

from flexmb.errors import ModelError, did_you_mean
from flexmb.model.kinds import Sensor

__all__ = ["Stress"]

COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "zx")


@dataclass(frozen=True, eq=False)
class Stress(Sensor):
    """Nodal stress of a flexible body by its stress modes, ``sigma = S eta``, in body axes, Pa.

    With one node: its von Mises stress (nt,) or, with ``component="tensor"``, xx, yy, zz, xy, yz, zx (nt, 6). With
    several nodes, or without: the largest von Mises stress (or component) among them at each time, (nt,).

    Parameters
    ----------
    name : str
    body : str
        Name of a body with stress modes.
    node : int, sequence of int, or None
        Node number or numbers in the body's data; None is the whole body.
    component : str
        "von_mises", "xx", "yy", "zz", "xy", "yz", "zx", or "tensor" (one node only).
    """

    _: KW_ONLY
    body: str
    node: int | Sequence[int] | None = None
    component: str = "von_mises"

    def __post_init__(self):
        super().__post_init__()
        known = ("von_mises", *COMPONENTS, "tensor")
        if self.component not in known:
            raise ModelError(
                self.title,
                found=f"component = {self.component!r}",
                expected=f"One of: {', '.join(known)}",
                remedy=did_you_mean(str(self.component), known) or "Omit it for von Mises stress",
            )
        if self.component == "tensor" and not isinstance(self.node, int | np.integer):
            raise ModelError(
                self.title,
                found=f"the tensor at node = {self.node!r}",
                expected="one node number",
                remedy="Name one node, or ask for one component",
            )

    def check(self, model) -> None:
        """Raise ModelError if the body has no stress modes or not these nodes."""
        body = model.body(self.body, self.title)
        data: Any = getattr(body, "data", None)
        if getattr(data, "stress_modes", None) is None:
            raise ModelError(
                self.title,
                found=f"body '{self.body}' ({type(body).__name__}) has no stress modes",
                expected="a FloatingBody whose data was reduced from a model with elements",
                remedy="Reduce a model made by fem.solid; rigid bodies have no stress",
            )
        nodes = np.atleast_1d(np.asarray([] if self.node is None else self.node))
        n = len(data.nodes)
        if nodes.size and (nodes.dtype.kind not in "iu" or nodes.min() < 0 or nodes.max() >= n):
            raise ModelError(
                self.title,
                found=f"node = {self.node!r}",
                expected=f"node numbers 0 to {n - 1}",
                remedy="Find the number of a node with numpy: argmin of its distance in data.nodes",
            )

    def columns(self, model) -> tuple[str, ...]:
        """Return the titles with the unit."""
        return tuple(f"{c} [Pa]" for c in COMPONENTS) if self.component == "tensor" else (f"{self.component} [Pa]",)

    def values(self, series) -> np.ndarray:
        """Return the stress (nt,) or (nt, 6), Pa."""
        if self.component == "tensor":
            return series.stress(self.body, self.node)[:, 0]
        if self.component == "von_mises":
            return series.largest_von_mises(self.body, self.node)
        return series.stress(self.body, self.node)[:, :, COMPONENTS.index(self.component)].max(axis=1)
