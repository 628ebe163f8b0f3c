"""The entries of the reference page of joints: made from the registered kinds, so that a new joint is on it at once."""

from __future__ import annotations

from flexmb import joints

GROUPS = {
    "Between two markers": lambda kind: not (kind.prescribes or kind.couples),
    "Prescribed motion": lambda kind: kind.prescribes,
    "Between joints": lambda kind: kind.couples and not kind.prescribes,
}
ENTRY = """### {name}

![{name}](../images/joints/{name}.png)

```{{eval-rst}}
.. autoclass:: flexmb.joints.{name}
   :no-members:
```
"""


def freedoms(kind) -> int:
    """Return how many freedoms a class of joints permits; joints whose fields decide come last."""
    return len(kind.permits) if isinstance(kind.permits, tuple) and kind.forbids else 9


def entries() -> str:
    """Return the entries of all kinds: few freedoms first."""
    parts = []
    for title, belongs in GROUPS.items():
        parts.append(f"## {title}\n")
        found = [name for name, kind in joints.KINDS.items() if belongs(kind)]
        parts += [ENTRY.format(name=name) for name in sorted(found, key=lambda name: freedoms(joints.KINDS[name]))]
    return "\n".join(parts)


def fill(app, page: str, source: list[str]) -> None:
    """Put the entries into the page (an event of Sphinx: `source` holds its text)."""
    if page == "reference/joints":
        source[0] = source[0].replace("% entries of all joints", entries())
