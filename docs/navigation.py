"""The list of pages beside each page: made from the titles alone.

Sphinx copies the headings of all pages for every page and then removes all but the titles: more than half of the time
of a build. Here the headings are left out before.
"""

from __future__ import annotations

from sphinx import addnodes


def titles(toc):
    """Return a copy of a table of contents with its titles and the lists of pages below them, as Sphinx keeps them."""
    kept = toc.deepcopy()
    for top in kept.children:
        if len(top) > 1:
            lists = list(top.findall(addnodes.toctree))
            if lists:
                top[1][:] = lists
            else:
                top.pop(1)
    return kept


def from_titles(app, page: str, template: str, context: dict, doctree) -> None:
    """Let the list of pages be made from titles (an event of Sphinx, before that of the theme)."""
    made, env = context.get("toctree"), app.env
    if made is None:
        return
    if not hasattr(app, "titles_of_pages"):
        app.titles_of_pages = {name: titles(toc) for name, toc in env.tocs.items()}

    def toctree(**wanted):
        whole = env.tocs
        if wanted.get("titles_only"):
            env.tocs = app.titles_of_pages
        try:
            return made(**wanted)
        finally:
            env.tocs = whole

    context["toctree"] = toctree
