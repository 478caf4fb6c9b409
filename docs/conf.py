"""Sphinx: `make docs` writes the pages to out/docs; nothing is fetched, and every warning is an error."""

import sys
import zlib
from pathlib import Path

from docutils import nodes
from latex2mathml.converter import convert

from mbsd3d import __all__ as public
from mbsd3d import __version__

sys.path.insert(0, str(Path(__file__).parent))  # the extensions beside this file

project, author, copyright = "mbsd3d", "The mbsd3d developers", "2026, the mbsd3d developers"
version = release = __version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.intersphinx", "numpydoc", "sphinx_copybutton"]
extensions += ["made_pages", "finding"]
exclude_patterns = ["notebooks"]
html_theme = "furo"
html_title = f"mbsd3d {release}"
html_static_path, html_css_files, html_js_files = ["_static"], ["site.css"], ["search.js"]
html_show_sourcelink = False
if tags.has("book"):  # noqa: F821, what Sphinx gives this file; see make_book.py
    html_theme, html_css_files, html_js_files = "basic", ["book.css"], []
html_theme_options = {"navigation_with_keys": True} if html_theme == "furo" else {}
pygments_style, pygments_dark_style = "friendly", "github-dark"

myst_enable_extensions = ["dollarmath", "deflist", "colon_fence"]
myst_heading_anchors = 3
nitpicky = False  # many types in docstrings are words: "float or None", "layer or list of layers"
autodoc_typehints = "none"  # the docstrings say shapes and units, which types cannot
autodoc_member_order = "bysource"
autodoc_default_options = {"exclude-members": "__init__, __new__"}
numpydoc_show_class_members = False
numpydoc_xref_param_type = True
numpydoc_xref_aliases = {name: f"mbsd3d.{name}" for name in public if name[0].isupper()}
numpydoc_xref_aliases |= {"array_like": ":term:`array_like`", "bool": ":class:`bool`", "Path": "pathlib.Path"}
numpydoc_xref_aliases |= {"None": "``None``", "callable": ":term:`callable`", "True": "``True``", "False": "``False``"}
numpydoc_xref_ignore = "all"  # but these

OTHERS = [line.split() for line in Path(__file__).with_name("inventories.txt").read_text("utf-8").splitlines()[2:]]
numpydoc_xref_aliases |= {words[1]: words[1] for words in OTHERS if words[0].startswith("py:") and "." in words[1]}
HEAD = (
    "# Sphinx inventory version 2\n# Project: {}\n# Version:\n# The remainder of this file is compressed using zlib.\n"
)
DISPLAYED = ".. code-block:: text"


def inventories(app, config) -> None:
    """The inventories that intersphinx reads, written from the text beside this file: nothing is fetched."""
    folder = Path(app.doctreedir) / "inventories"
    folder.mkdir(parents=True, exist_ok=True)
    lines: dict[str, list[str]] = {}
    for words in OTHERS:
        if len(words) == 2:  # the next project
            project, address = words
            lines[project] = []
            config.intersphinx_mapping[project] = address, str(folder / project)
        else:
            role, name, page = words
            lines[project].append(f"{name} {role} 1 {page.replace('$', name)} -\n")
    for project, found in lines.items():
        (folder / project).write_bytes(HEAD.format(project).encode() + zlib.compress("".join(found).encode()))


def mathml(self, node: nodes.math | nodes.math_block) -> None:
    """An equation as MathML, which browsers draw themselves: no script, no font, no network."""
    display = "block" if isinstance(node, nodes.math_block) else "inline"
    self.body.append(convert(node.astext(), display=display))
    raise nodes.SkipNode


def displayed_equations(app, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """Indented lines between the paragraphs of a docstring are equations and keep their lines."""
    head = next((k for k, line in enumerate(lines) if line.startswith("---")), len(lines))  # where sections begin
    for k in range(head - 1, 1, -1):
        before = lines[k - 2]
        if lines[k].startswith("    ") and not lines[k - 1] and before and not before.startswith(" "):
            lines[k - 2 : k] = [before.removesuffix(":") if before.endswith("::") else before, "", DISPLAYED, ""]


def absolute_values(app, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """|x| in a docstring is an absolute value and no substitution; literals and equations stay as they are."""
    displayed = False
    for k, line in enumerate(lines):
        displayed = line == DISPLAYED or (displayed and (not line or line.startswith(" ")))
        pieces = line.split("``")
        pieces[::2] = [piece.replace("|", r"\|") for piece in pieces[::2]]
        lines[k] = line if displayed else "``".join(pieces)


def setup(app) -> None:
    app.connect("config-inited", inventories, priority=100)  # before intersphinx checks what it was given
    app.connect("autodoc-process-docstring", displayed_equations, priority=100)
    app.connect("autodoc-process-docstring", absolute_values, priority=900)
    app.add_html_math_renderer("mathml", (mathml, None), (mathml, None))
    app.config.html_math_renderer = "mathml"
