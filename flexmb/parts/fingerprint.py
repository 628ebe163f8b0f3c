"""A finite element model as a digest of its content: equal models and settings give equal data."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from scipy import sparse

from flexmb.fem.fe_model import ElementBlock, FEModel

__all__ = ["fingerprint"]


def fingerprint(fe: FEModel, settings: tuple) -> str:
    """Return 20 hexadecimal digits of a hash over matrices, mesh, groups and settings."""
    digest = hashlib.sha256()
    cells = [(block.cell_type, np.asarray(block.connectivity), *_answers(block, len(fe.nodes))) for block in fe.blocks]
    content = (
        fe.name,
        fe.nodes,
        fe.dofs,
        fe.K,
        fe.M,
        fe.expansion,
        fe.C,
        cells,
        fe.node_sets,
        fe.facet_sets,
        [(name, at.node, at.averaged, at.weights) for name, at in sorted(fe.reference_points.items())],
        fe.numbering,
        fe.warnings,
        fe.source,
        () if fe.condensed is None else (fe.condensed.whole.M, fe.condensed.fields),
    )
    for part in _parts((content, settings)):
        digest.update(part)
    return digest.hexdigest()[:20]


def _answers(block: ElementBlock, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return what elements answer to one given displacement: stress and geometric stiffness know what K does not.

    The side of a shell, for one, at which its stress is taken.
    """
    field = np.random.default_rng(0).standard_normal((n, 6, 1))
    return block.nodal_stress(field), block.projected_geometric_stiffness(field, field)


def _parts(value: Any):
    """Yield the bytes of nested content; the kind and size go with them, so that no two contents look alike."""
    if isinstance(value, np.ndarray):
        yield f"array {value.dtype} {value.shape}".encode()
        yield np.ascontiguousarray(value).tobytes()
    elif sparse.issparse(value):
        csr = value.tocsr()
        yield from _parts((csr.shape, csr.indptr, csr.indices, csr.data))
    elif isinstance(value, Mapping):
        yield from _parts([item for key in value for item in (key, value[key])])
    elif isinstance(value, (tuple, list)):
        yield f"list {len(value)}".encode()
        for item in value:
            yield from _parts(item)
    elif is_dataclass(value) and not isinstance(value, type):
        yield type(value).__name__.encode()
        yield from _parts([getattr(value, f.name) for f in fields(value)])
    else:
        yield f"{type(value).__name__} {value!r}".encode()
