"""Sphinx extension: links to the repository, once its address is known.

The one place for the address is [project.urls] Repository in pyproject.toml. While it is not
there, no launch button, edit link or badge is made.
"""

import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def address():
    """Give the repository's address, None while there is none."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    return project.get("urls", {}).get("Repository")


def add_links(app, config):
    """Switch on what needs the address."""
    url = address()
    if not url:
        return
    config.html_theme_options |= {
        "repository_url": url,
        "path_to_docs": "",
        "use_repository_button": True,
        "use_issues_button": True,
        "use_edit_page_button": True,
        "launch_buttons": {
            "notebook_interface": "jupyterlab",
            "binderhub_url": "https://mybinder.org",
            "colab_url": "https://colab.research.google.com",
        },
    }


def setup(app):
    """Register the hook."""
    app.connect("config-inited", add_links, priority=400)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
