"""Sphinx configuration: Markdown pages, a reference generated from the code, everything usable offline."""

import sys
from pathlib import Path

from pygments.lexers.special import TextLexer

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

from reference import write_reference  # noqa: E402 - beside this file, made reachable above

from tendon_cli import __version__  # noqa: E402

project = "tendon"
author = "The tendon developers"
copyright = "the tendon developers, MIT licence"  # noqa: A001 - the name Sphinx asks for
release = version = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
source_suffix = {".md": "markdown"}
exclude_patterns = ["_build"]
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3
nitpicky = False
autodoc_typehints = "signature"
autodoc_member_order = "bysource"

html_theme = "furo"
html_title = f"tendon {__version__}"
html_static_path = []
html_show_sphinx = False
pygments_style = "friendly"
pygments_dark_style = "native"


def setup(app):
    """Write the generated pages before Sphinx looks for sources."""
    app.add_lexer("csv", TextLexer)
    app.connect("builder-inited", lambda _app: write_reference(HERE / "reference"))
