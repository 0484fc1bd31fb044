"""Sphinx configuration: Markdown pages and the library; all offline."""

import re
from pathlib import Path

from docutils.nodes import SkipNode, literal, raw, row, table
from latex2mathml.converter import convert
from pygments.lexers.special import TextLexer
from sphinx.addnodes import index
from sphinx.transforms import SphinxTransform

from tendon_cli import __version__

project = "tendon"
author = "The tendon developers"
copyright = "the tendon developers, MIT licence"  # noqa: A001 - the name Sphinx asks for
release = __version__
version = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["_build", "pages", "notebooks"]
# Pages of HTML that figures.py makes, such as the report of the demo.
html_extra_path = ["pages"] if Path(__file__).with_name("pages").is_dir() else []
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


class IndexFirstColumns(SphinxTransform):
    """Index what a table of reference lists, so that a search finds a key's own entry first."""

    default_priority = 800  # before Sphinx collects what is indexed

    def apply(self):  # noqa: D102 - as Sphinx names it
        for mark in list(self.document.findall(raw)):
            if not mark.astext().startswith("<!-- from the code") or "usual" in mark.astext():
                continue
            for line in mark.next_node(table, siblings=True, descend=False).findall(row):
                for name in list(line[0].findall(literal)):
                    # A search is for "--out" or "tendon plot", without what goes in their place.
                    text = re.split(r" (?=[A-Z[]|\w+[|:])|\(", name.astext())[0]
                    place = self.document.set_id(name)
                    name.parent.append(index(entries=[("single", text, place, "", None)]))


def setup(app):
    """Connect what Sphinx calls: an index of keys, plain tables of numbers, formulas as MathML."""
    app.add_transform(IndexFirstColumns)
    app.add_lexer("csv", TextLexer)
    app.add_html_math_renderer("mathml", (write_inline, None), (write_displayed, None))
