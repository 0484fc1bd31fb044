"""Sphinx configuration: Markdown pages, notebooks that are run, the library; all offline."""

import os
import sys
import tempfile
from pathlib import Path

from docutils.nodes import SkipNode
from latex2mathml.converter import convert
from pygments.lexers.special import TextLexer

from tendon_cli import __version__

sys.path.insert(0, str(Path(__file__).parent))
import messages  # beside this file

project = "tendon"
author = "The tendon developers"
copyright = "the tendon developers, MIT licence"  # noqa: A001 - the name Sphinx asks for
release = __version__
version = __version__

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["_build", "jupyter_execute", "pages"]
# Pages of HTML that figures.py makes, such as the report of the demo.
html_extra_path = ["pages"] if Path(__file__).with_name("pages").is_dir() else []
# Each notebook is run with the pages, and a cell that fails ends the build.
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 300
# Without this setting each kernel warns that it talks to this process.
quiet = Path(tempfile.mkdtemp(), "profile_default")
quiet.mkdir()
(quiet / "ipython_kernel_config.py").write_text("c.Application.log_level = 40\n", encoding="utf-8")
os.environ["IPYTHONDIR"] = str(quiet.parent)
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3
nitpicky = False
autodoc_typehints = "signature"
autodoc_member_order = "bysource"

html_theme = "furo"
# Browsers draw MathML themselves; MathJax would come from the network.
html_math_renderer = "mathml"
html_title = f"tendon {__version__}"
html_static_path = ["_static"]
html_css_files = ["phone.css"]
html_show_sphinx = False
html_show_search_summary = False  # a browser does not let a page of a folder read its neighbours
# Otherwise "--reversal" and quotes in a copied command would become typographic signs.
smartquotes = False
pygments_style = "friendly"
pygments_dark_style = "native"


def write_inline(writer, node):
    """Write a formula within a line."""
    writer.body.append(convert(node.astext()))
    raise SkipNode


def write_displayed(writer, node):
    """Write a formula that stands alone."""
    writer.body.append(convert(node.astext(), display="block"))
    raise SkipNode


def insert_messages(_app, _page, source):
    """Insert all messages into the page that asks for it."""
    place = "<!-- every message, from the code -->"
    if place in source[0]:
        source[0] = source[0].replace(place, messages.sections())


def setup(app):
    """Connect what Sphinx calls: messages, plain tables of numbers, formulas as MathML."""
    app.connect("source-read", insert_messages)
    app.add_lexer("csv", TextLexer)
    app.add_html_math_renderer("mathml", (write_inline, None), (write_displayed, None))
