"""Sphinx extension: leave out the field list of named tuples; their docstrings say it better."""


def skip(app, what, name, member, skip_it, options):
    """Skip what carries only Python's own words."""
    if (getattr(member, "__doc__", "") or "").startswith("Alias for field number"):
        return True
    return None


def setup(app):
    """Register the hook."""
    app.connect("autodoc-skip-member", skip)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
