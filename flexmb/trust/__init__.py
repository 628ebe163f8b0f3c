"""How far a solution can be trusted: a second opinion by ways that its integrator has not gone."""

from flexmb.trust.verification import Answer, Check, Verification
from flexmb.trust.verify import verify

__all__ = ["Answer", "Check", "Verification", "verify"]
