"""Why the passes along links cannot go on: a joint or a bent body whose motion has no inertia."""

from __future__ import annotations

import numpy as np

from flexmb.errors import CompileError
from flexmb.tree.rigid.link_tree import LinkTree
from flexmb.tree.rigid.places import BEND

__all__ = ["without_inertia"]


def without_inertia(tree, links: LinkTree, model) -> CompileError:
    """Return the error about the link at which a pass to the roots stopped (`run.failed`); tree : Spanning."""
    link = links.links[links.run[0].failed]
    name = tree.order[link["body"]]
    where = f"Body '{name}'" + (f" (joint '{tree.joints[name]}')" if name in tree.joints else "")
    unknown = not np.all(np.isfinite(links.x)) or not np.all(np.isfinite(links.v))
    if unknown:
        return CompileError(
            where,
            found="coordinates or rates have no value (nan)",
            expected="finite coordinates and rates",
            remedy="Give numbers; in a run, look at its last samples",
        )
    if link["kind"] == BEND and _is_stiffened(model.body(name)):
        return CompileError(
            where,
            found="with these modal coordinates it is bent so far that its geometric stiffness by accelerations takes "
            "all the inertia of a motion of its modes",
            expected="deflections that are small beside the size of the body",
            remedy="Give smaller modal coordinates, or reduce the body with fewer modes",
        )
    return CompileError(
        where,
        found="its modes have no inertia in some direction"
        if link["kind"] == BEND
        else "its articulated inertia is singular",
        expected="inertia, its own or carried, in every free motion of its joint",
        remedy="Look at the mass matrix of its data, or leave that mode out (modes=)"
        if link["kind"] == BEND
        else "Give the body mass and inertia about the free axis",
    )


def _is_stiffened(body) -> bool:
    """Has a flexible body geometric stiffness that takes from its inertia when it is bent: by accelerations, or by the
    wrenches on interfaces, which follow those of what it carries?
    """
    link = body.modal_link()
    return link is not None and bool(np.any(link.inertia_stiffening) or np.any(link.interface_stiffening))
