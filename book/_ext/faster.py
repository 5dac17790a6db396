"""The book is built in less time: no page keeps what it does not need, and all cores work."""

import gc
import os

OBJECTS = 100_000
"""New objects between two looks for garbage; 700 by default: often for a book's trees of nodes."""


def give_up_inner_documents(app, doctree):
    """Nodes that a directive parsed belong to the page.

    An ``eval-rst`` block parses in a document of its own, which holds the whole environment:
    kept, it is written with each page, a megabyte and a half in place of 0.1.
    """
    for node in doctree.findall():
        node.document = doctree


def let_all_cores_read(app, config):
    """One extension says nothing on that; it numbers sections after all pages have been read."""
    app.extensions["sphinx_multitoc_numbering"].parallel_read_safe = True


def setup(app):
    """All cores read and write, and look for garbage less often."""
    app.parallel = (os.cpu_count() or 1) + 1  # the one that hands out pages has little to do
    gc.set_threshold(OBJECTS, 20, 100)
    app.connect("config-inited", let_all_cores_read)
    app.connect("doctree-read", give_up_inner_documents, priority=900)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
