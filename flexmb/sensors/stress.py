"""`Stress`: stress of a flexible body at a node, or the largest in a region."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any

import numpy as np

from flexmb.constraints import Measured
from flexmb.errors import ModelError, did_you_mean
from flexmb.model.described import whole
from flexmb.model.kinds import Sensor
from flexmb.model.node_places import place_of
from flexmb.model.numbering import named_numbers
from flexmb.sensors.flexible_coordinate import combined, reduced_data

__all__ = ["Stress"]

COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "zx")


@dataclass(frozen=True, eq=False)
class Stress(Sensor):
    """Nodal stress of a flexible body by its stress modes, ``sigma = S eta``, in body axes, Pa.

    With one node: its von Mises stress (nt,) or, with ``component="tensor"``, xx, yy, zz, xy, yz, zx (nt, 6). With
    several nodes, a set, or without: the largest von Mises stress (or component) among them at each time, (nt,). Nodes
    of a set at which no element gives stress do not count.

    Parameters
    ----------
    name : str
    body : str
        Name of a body with stress modes.
    node : int, str, (3,), m, sequence of these, or None
        Name of a node or element set, a part or a material of the mesh or deck; ``"node 63241"`` or ``"element 812"``,
        numbers of the deck; node numbers in the body's data; or the place of a node in the axes of the mesh, of whose
        coordinates one has a decimal point. None is the whole body.
    component : str
        "von_mises", "xx", "yy", "zz", "xy", "yz", "zx", or "tensor" (one node only).
    """

    _: KW_ONLY
    body: str
    node: int | str | Sequence[int | float | str | Sequence[float]] | None = None
    component: str = "von_mises"

    def __post_init__(self):
        super().__post_init__()
        object.__setattr__(self, "node", _whole_but_places(self.node))
        known = ("von_mises", *COMPONENTS, "tensor")
        if self.component not in known:
            raise ModelError(
                self.title,
                found=f"component = {self.component!r}",
                expected=f"One of: {', '.join(known)}",
                remedy=did_you_mean(str(self.component), known) or "Omit it for von Mises stress",
            )
        one = isinstance(self.node, int | np.integer | str) or place_of(self.node) is not None
        if self.component == "tensor" and not one:
            raise self._no_tensor(f"node = {self.node!r}")

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
        if self.node is None:
            if data.n_modes and not len(_stressed(data, np.arange(len(data.nodes)))):
                raise ModelError(
                    self.title,
                    found=f"body '{self.body}', whose elements are beams, rods or springs: none gives stress",
                    expected="a body with solids or shells",
                    remedy="Their forces and moments: results.recover.section_forces",
                )
            return
        nodes = data.nodes_named(self.node, self.title)
        if line := next((word for word in self._words() if _is_line(data, word)), None):
            raise ModelError(
                self.title,
                found=f"'{line}', a beam, rod or spring, which has no stress modes",
                expected="elements that are solids or shells",
                remedy="See results.recover.section_forces; name its nodes for the stress of shells there",
            )
        if not len(_stressed(data, nodes)) and data.n_modes:
            raise ModelError(
                self.title,
                found=f"{len(nodes)} nodes, first {data.node_name(nodes[0])}, at which no element gives stress"
                if len(nodes)
                else f"no nodes by node = {self.node!r}",
                expected="nodes of solids or shells",
                remedy="Beams, rods, springs and reference points of links have forces: results.recover.section_forces",
            )
        if self.component == "tensor" and len(nodes) != 1:
            raise self._no_tensor(f"the {len(nodes)} nodes of '{self.node}'")

    def _words(self) -> list[str]:
        """Return the names among the places."""
        given = self.node if isinstance(self.node, list | tuple) else [self.node]
        return [word for word in given if isinstance(word, str)]

    def _no_tensor(self, where: str) -> ModelError:
        return ModelError(
            self.title,
            found=f"the tensor at {where}",
            expected="one node number or name",
            remedy="Name one node, or ask for one component",
        )

    def _nodes(self, series) -> np.ndarray | None:
        """Return the node numbers, without those that no element gives stress to; None for the whole body."""
        if self.node is None:
            return None
        data = series.model.body(self.body).data
        return _stressed(data, data.nodes_named(self.node, self.title))

    def columns(self, model) -> tuple[str, ...]:
        """Return the titles with the unit."""
        return tuple(f"{c} [Pa]" for c in COMPONENTS) if self.component == "tensor" else (f"{self.component} [Pa]",)

    def measured(self, model) -> tuple[Measured, ...]:
        """Return components at one node, which are linear in the flexible coordinates."""
        self.check(model)
        data = reduced_data(model, self.body, self.title)
        nodes = np.empty(0) if self.node is None else _stressed(data, data.nodes_named(self.node, self.title))
        if self.component == "von_mises" or len(nodes) != 1:
            raise ModelError(
                self.title,
                found=f"{self.component} at {len(nodes) or 'all'} nodes, which cannot be measured while the motion is "
                "computed",
                expected="one component, or the tensor, at one node",
                remedy='Write node=12, component="xx"',
            )
        rows = data.stress_modes[nodes[0]]
        wanted = range(6) if self.component == "tensor" else [COMPONENTS.index(self.component)]
        return tuple(combined(self.body, rows[k]) for k in wanted)

    def values(self, series) -> np.ndarray:
        """Return the stress (nt,) or (nt, 6), Pa."""
        if self.component == "tensor":
            return series.stress(self.body, self._nodes(series))[:, 0]
        if self.component == "von_mises":
            return series.largest_von_mises(self.body, self._nodes(series))
        return series.stress(self.body, self._nodes(series))[:, :, COMPONENTS.index(self.component)].max(axis=1)


def _whole_but_places(node: Any) -> Any:
    """Return node numbers that arithmetic made floats as integers, and places as tuples of floats."""
    if (place := place_of(node)) is not None:
        return place
    if isinstance(node, list | tuple):
        return type(node)(map(_whole_but_places, node))
    return whole(node)


def _is_line(data, word: str) -> bool:
    """Whether a word is the number of an element that is a line."""
    named = named_numbers(word)
    if word in data.node_sets or named is None or named[0] != "element" or data.numbering is None:
        return False
    kinds = {kind for (kind, _), labels in zip(data.cells, data.numbering.cells) if (labels == named[2]).any()}
    return bool(kinds) and all(kind.startswith("line") for kind in kinds)


def _stressed(data, nodes: np.ndarray) -> np.ndarray:
    """Return the nodes whose stress is not zero in every mode."""
    return nodes[data.stressed[nodes]] if data.n_modes else nodes
