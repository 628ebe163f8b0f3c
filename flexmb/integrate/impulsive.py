"""Rigid contacts need a method of impulses: whatever else would not see them, and says so."""

from __future__ import annotations

from flexmb.errors import ModelError

__all__ = ["refuse_crowds", "refuse_impulses", "require_method", "rigid_contacts"]


def rigid_contacts(model) -> list:
    """Return the forces of a model whose law stops bodies by impulses."""
    return [force for force in model.forces if force.impulsive]


def refuse_impulses(model, asker: str) -> None:
    """Raise ModelError if a model has rigid contacts, of which the asker knows nothing."""
    found = rigid_contacts(model)
    if found:
        raise ModelError(
            found[0].title,
            found=f"a rigid law, and {asker}, which follows forces and no impulses",
            expected="simulate(..., integrator=flexmb.MoreauJean(step=...)), or a compliant law",
            remedy="Give that integrator, or law=flexmb.Hertz(...), flexmb.ElasticFoundation(...)",
        )


def require_method(model, integrator, asker: str) -> None:
    """Raise ModelError if a model has rigid contacts and the integrator no impulses."""
    if not getattr(integrator, "impulsive", False):
        refuse_impulses(model, f"{asker} with {type(integrator).__name__}")


def refuse_crowds(model, asker: str) -> None:
    """Raise ModelError if a model has a crowd of surfaces, whose tangent is incomplete, and the asker needs it."""
    for force in model.forces:
        if getattr(force, "crowded", None) and force.crowded(model):
            raise ModelError(
                force.title,
                found=f"a crowd of surfaces, and {asker}, which needs the derivatives of every contact by both bodies",
                expected="few surfaces, which are looked at pair by pair",
                remedy="Name smaller groups, of surfaces that can meet, in several contacts",
            )
