"""Sphinx's settings for the site that `make docs` writes to build/help and the lab serves."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))  # the two modules beside this one

import offline
import reference

from motionlab import __version__

project = "PSRM Motion Lab"
release = __version__
copyright = f"PSRM Motion Lab contributors, MIT licence; version {release}"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
source_suffix = {".md": "markdown", ".ipynb": "markdown"}  # which `reference.generate` makes

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
html_math_renderer = "mathml"
autodoc_typehints = "description"
napoleon_google_docstring = False
napoleon_use_rtype = False

html_theme = "furo"
html_title = project
html_favicon = "../frontend/public/favicon.svg"
html_copy_source = False
html_show_sphinx = False
html_use_index = False
html_theme_options = {"top_of_page_buttons": []}
html_permalinks_icon = "#"
pygments_dark_style = "github-dark"


def setup(app):
    """Generate the reference as pages are read; slim the site when it is written."""
    app.connect("source-read", reference.generate)
    app.connect("autodoc-process-docstring", reference.link_pages)
    app.connect("build-finished", offline.slim)
    app.add_html_math_renderer("mathml", (offline.inline_math, None), (offline.block_math, None))
