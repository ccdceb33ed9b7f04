"""The site: `make docs` builds it into docs/_build/html, and looks at it in a browser."""

import os
import re
import sys
from pathlib import Path

from docutils import nodes
from sphinx import addnodes

ROOT = Path(__file__).parents[1]
os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])  # cells call `poinsot`
sys.path.insert(0, str(ROOT))

from tools.site.build import write_pages  # noqa: E402
from tools.site.names import canonical_names, linked_names  # noqa: E402
from tools.site.queries import with_index_entries  # noqa: E402
from tools.site.search import keep_text, write_texts  # noqa: E402

import poinsot  # noqa: E402

project, author, copyright = "poinsot", "The poinsot developers", "The poinsot developers"  # noqa: A001
version = release = poinsot.__version__

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "numpydoc",
    "myst_nb",
    "sphinx_design",
]
exclude_patterns = ["_build", "images"]
templates_path = ["_templates"]
default_role = "literal"
nitpicky = True

html_theme = "pydata_sphinx_theme"
html_title = "poinsot"
html_static_path = ["_static"]
html_extra_path = ["generated/extra"]
(ROOT / "docs" / "generated" / "extra").mkdir(parents=True, exist_ok=True)
html_css_files = ["site.css"]
html_js_files = ["from_disk.js", "scenes.js"]
html_copy_source = html_show_sourcelink = False
html_context = {"default_mode": "auto"}  # theme of the first visit: the preference of the system
html_theme_options = {
    "show_toc_level": 2,
    "navigation_with_keys": False,
    "header_links_before_dropdown": 6,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
}
mathjax_path = "mathjax/tex-svg-full.js"  # one file: pages from disk may not fetch fonts

myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence", "deflist"]
myst_heading_anchors = 4
nb_execution_mode = "cache"
nb_execution_in_temp = nb_execution_raise_on_error = True
nb_execution_show_tb = True
nb_execution_timeout = 300
nb_merge_streams = True
nb_ipywidgets_js = {}

autodoc_typehints = "none"
autodoc_member_order = "groupwise"
toc_object_entries_show_parents = "hide"
autodoc_inherit_docstrings = True
autosummary_generate = False
numpydoc_show_class_members = False

CANONICAL, LINKED = canonical_names(), linked_names()
NO_LINKS = (nodes.title, nodes.reference, addnodes.pending_xref, addnodes.desc_signature, addnodes.toctree)
NO_REQUESTS = (
    "default-src 'self' file:; script-src 'self' file: 'unsafe-inline'; style-src 'self' file: 'unsafe-inline'; "
    "img-src 'self' file: data: blob:; font-src 'self' file: data:; worker-src blob:; connect-src 'self' file:"
)


def without_substitutions(app, what, name, thing, options, lines):
    """Write the bars of |q| so that they are no substitution, in docstrings as they are read in a terminal."""
    lines[:] = [line if line.lstrip().startswith(">>>") else re.sub(r"\|(?=\S)", r"\\|", line) for line in lines]
    lines[:] = [re.sub(r"\bdocs/(\w+)\.md", r":doc:`\1 </\1>`", line) for line in lines]


def with_links_on_the_site(app, name, content):
    """Lead links that leave the folder of the pages to the pages made from these files."""
    up = "../" * name.count("/")
    content[0] = re.sub(r"\]\(\.\./examples/(\w+)\.py\)", rf"]({up}generated/gallery/\1.md)", content[0])
    content[0] = content[0].replace("](../CONTRIBUTING.md)", f"]({up}generated/contributing.md)")


def with_links_to_names(app, doctree):
    """Let code that is a public name, and public classes among the kinds of arguments, lead to their pages."""
    here = app.env.docname.removeprefix("generated/api/")

    def linked(name, shown):
        link = {"refdomain": "py", "reftype": "obj", "reftarget": name, "refexplicit": True, "refwarn": True}
        return addnodes.pending_xref("", shown, refdoc=app.env.docname, **link)

    for code in list(doctree.findall(nodes.literal)):
        name = LINKED.get(re.sub(r"\(.*\)$", "", code.astext(), flags=re.DOTALL))
        if name and name != here and not any(isinstance(parent, NO_LINKS) for parent in parents(code)):
            code.replace_self(linked(name, code.deepcopy()))
    for kind in doctree.findall(nodes.classifier):
        words = re.split(r"(\b[A-Z]\w+)", kind.astext())
        kind[:] = [
            linked(LINKED[each], nodes.inline("", each)) if each in LINKED else nodes.Text(each) for each in words
        ]


def parents(node):
    """Give the nodes around a node, from within."""
    while node.parent is not None:
        node = node.parent
        yield node


def known_elsewhere(app, env, node, contnode):
    """Find an object under each of the names that lead to it."""
    target = CANONICAL.get(node.get("reftarget", ""))
    if target and target != node["reftarget"]:
        return env.get_domain("py").resolve_xref(env, node["refdoc"], app.builder, "obj", target, node, contnode)
    return None


def without_requests(app, pagename, templatename, context, doctree):
    """Forbid every page to ask for anything but its own files; that of the search loads the texts of the others."""
    rule = f'<meta http-equiv="Content-Security-Policy" content="{NO_REQUESTS}">'
    context["metatags"] = f"{rule}\n{context.get('metatags', '')}"
    if pagename == "search":
        app.add_js_file("texts.js")


def with_named_toggles(app, pagename, templatename, context, doctree):
    """Name the buttons that unfold parts of the table of contents, for screen readers."""
    generate = context["generate_toctree_html"]

    def named(*args, **options):
        return str(generate(*args, **options)).replace("<summary>", '<summary aria-label="Subpages">')

    context["generate_toctree_html"] = named


def setup(app):
    """Make the pages that follow from the package, and connect the steps above."""
    app.connect("builder-inited", lambda app: write_pages(Path(app.srcdir) / "generated"))
    app.connect("autodoc-process-docstring", without_substitutions, priority=900)
    app.connect("source-read", with_links_on_the_site)
    app.connect(
        "source-read", lambda app, name, text: with_index_entries(name, text, Path(app.env.doc2path(name)).suffix)
    )
    app.connect("doctree-read", with_links_to_names)
    app.connect("missing-reference", known_elsewhere)
    app.connect("html-page-context", without_requests)
    app.connect("html-page-context", with_named_toggles, priority=900)
    app.connect("doctree-resolved", keep_text)
    app.connect("build-finished", write_texts)
