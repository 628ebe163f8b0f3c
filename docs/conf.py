"""Sphinx configuration: ``sphinx-build -W docs docs/_build``."""

import sys
from importlib.metadata import version as _version
from pathlib import Path as _Path

_here = _Path(__file__).parent
sys.path[:0] = [str(_here), str(_here / "images")]

project = "flexmb"
author = "flexmb developers"
copyright = "2026, flexmb developers"
version = release = _version("flexmb")

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["_build"]

html_theme = "furo"
html_title = f"flexmb {release}"

# Theory pages: $...$ and labelled blocks of equations, numbered through each page.
myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath", "fieldlist"]
myst_heading_anchors = 3
math_eqref_format = "({number})"

# Reference pages: signatures as they are written, members in the order of the file.
autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_default_options = {"members": True}
autodoc_class_signature = "mixed"
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False
suppress_warnings = ["ref.python"]  # where a type is expected, the docstrings have shape and unit: "(n, 3), m"


def setup(app):
    """Draw the joints, and write their entries, from what is registered; list the pages from their titles."""
    import draw_joints
    import joint_entries
    import navigation

    app.connect("builder-inited", lambda app: draw_joints.draw())
    app.connect("source-read", joint_entries.fill)
    app.connect("html-page-context", navigation.from_titles, priority=100)
