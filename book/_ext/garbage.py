"""Python looks for circular garbage less often while the book is built: a third less time."""

import gc

OBJECTS = 100_000
"""New objects between two looks; 700 by default, which is often for a book's trees of nodes."""


def setup(app):
    """Set the threshold."""
    gc.set_threshold(OBJECTS, 20, 100)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
