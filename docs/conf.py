"""Sphinx: `make docs` writes the pages to out/docs; nothing is fetched, and every warning is an error."""

from docutils import nodes
from latex2mathml.converter import convert

from mbsd3d import __version__

project, author, copyright = "mbsd3d", "The mbsd3d developers", "2026, the mbsd3d developers"
version = release = __version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "numpydoc", "sphinx_copybutton"]
exclude_patterns = ["notebooks"]
html_theme = "furo"
html_title = f"mbsd3d {release}"
html_static_path, html_css_files = ["_static"], ["site.css"]
html_show_sourcelink = False
html_theme_options = {"navigation_with_keys": True}
pygments_style, pygments_dark_style = "friendly", "github-dark"

myst_enable_extensions = ["dollarmath", "deflist", "colon_fence"]
myst_heading_anchors = 3
nitpicky = False  # types of numpy stand in docstrings as words, and no inventory is fetched
autodoc_typehints = "none"  # the docstrings say shapes and units, which types cannot
autodoc_member_order = "bysource"
autodoc_default_options = {"exclude-members": "__init__, __new__"}
numpydoc_show_class_members = False


def mathml(self, node: nodes.math | nodes.math_block) -> None:
    """An equation as MathML, which browsers draw themselves: no script, no font, no network."""
    display = "block" if isinstance(node, nodes.math_block) else "inline"
    self.body.append(convert(node.astext(), display=display))
    raise nodes.SkipNode


def absolute_values(app, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """|x| in a docstring is an absolute value and no substitution; literals stay as they are."""
    for k, line in enumerate(lines):
        pieces = line.split("``")
        pieces[::2] = [piece.replace("|", r"\|") for piece in pieces[::2]]
        lines[k] = "``".join(pieces)


def setup(app) -> None:
    app.connect("autodoc-process-docstring", absolute_values, priority=900)
    app.add_html_math_renderer("mathml", (mathml, None), (mathml, None))
    app.config.html_math_renderer = "mathml"
