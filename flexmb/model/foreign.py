"""`Foreign`: the name of a Python function that came with a file, and may not be imported."""

from __future__ import annotations

__all__ = ["Foreign"]


class Foreign(str):
    """A text "module:function" from a model file that was read without trust in its author.

    It stays what it is in copies of the part, in processes and in files; whoever would import it looks at its type.
    """

    __slots__ = ()
