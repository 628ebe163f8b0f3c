"""Why the passes along links cannot go on: a joint or a bent body whose motion has no inertia."""

from __future__ import annotations

from flexmb.errors import CompileError
from flexmb.tree.rigid.link_tree import LinkTree
from flexmb.tree.rigid.places import BEND

__all__ = ["without_inertia"]


def without_inertia(tree, links: LinkTree) -> CompileError:
    """Return the error about the link at which a pass to the roots stopped (`run.failed`); tree : Spanning."""
    link = links.links[links.run[0].failed]
    name = tree.order[link["body"]]
    where = f"Body '{name}'" + (f" (joint '{tree.joints[name]}')" if name in tree.joints else "")
    if link["kind"] == BEND:
        return CompileError(
            where,
            found="with these modal coordinates it is bent so far that its geometric stiffness by accelerations takes "
            "more than the inertia of its modes",
            expected="deflections that are small beside the size of the body",
            remedy="Give smaller modal coordinates, or reduce the body with fewer modes",
        )
    return CompileError(
        where,
        found="its articulated inertia is singular",
        expected="inertia, its own or carried, in every free motion of its joint",
        remedy="Give the body mass and inertia about the free axis",
    )
