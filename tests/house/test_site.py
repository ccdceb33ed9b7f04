"""The pages of the site: what they are made from, and, once `make docs` has built them, what they ask for and show."""

import re
import shutil
from pathlib import Path
from urllib.parse import unquote

import pytest
from tools.site import api, gallery, names, queries

ROOT = Path(__file__).parents[2]
SITE = ROOT / "docs" / "_build" / "html"
BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)

REQUEST = re.compile(r"""<(?:script|img|iframe|link|source|video)\b[^>]*?(?:src|href|data)=["'](?:https?:)?//""")
STYLE_REQUEST = re.compile(r"""(?:url\(|@import\s)\s*["']?(?:https?:)?//""")
"""What loads something from elsewhere; links to other sites load nothing until they are followed."""


def test_every_example_is_in_one_group_of_the_gallery():
    grouped = [name for group in gallery.GROUPS.values() for name in group.split()]
    assert sorted(grouped) == sorted({path.stem for path in (ROOT / "examples").glob("*.[pt][yo]*")})
    assert sorted(gallery.QUESTIONS) == sorted(grouped)
    assert all(len(question) < 60 and question.endswith("?") for question in gallery.QUESTIONS.values())


@pytest.mark.parametrize("path", sorted((ROOT / "examples").glob("*.py")), ids=lambda path: path.stem)
def test_every_example_begins_with_a_title(path):
    title, text = gallery.described(path.stem)
    assert 5 < len(title) < 60
    assert not re.search(r"[:;.]", title)
    assert len(text) > len(title)


def test_every_name_of_the_root_is_in_one_group_of_the_api():
    grouped = [f"poinsot.{name}" for group in api.ROOT_GROUPS.values() for name in group.split()]
    assert sorted(grouped) == sorted(name for name in names.public() if name.count(".") == 1)


@pytest.mark.docs
def test_no_page_loads_anything_from_elsewhere():
    pages = list(SITE.rglob("*.html"))
    assert len(pages) > 100
    assert [str(page) for page in pages if REQUEST.search(page.read_text())] == []
    assert [str(sheet) for sheet in SITE.rglob("*.css") if STYLE_REQUEST.search(sheet.read_text())] == []


@pytest.mark.docs
def test_links_within_the_site_lead_somewhere():
    pages = {path: path.read_text() for path in SITE.rglob("*.html") if "_static" not in path.parts}
    names = {path: set(re.findall(r'\bid="([^"]+)"', text)) for path, text in pages.items()}
    lost = []
    for path, text in pages.items():
        for link in re.findall(r'\b(?:href|src)="(?!https?:|data:|mailto:|#")([^"]+)"', text):
            target, _, anchor = unquote(link).partition("#")
            found = (path.parent / target.partition("?")[0]).resolve() if target else path
            if not found.exists() or (anchor and found in names and anchor not in names[found]):
                lost.append((path.relative_to(SITE).as_posix(), link))
    assert lost == []


# ------------------------------------------------------------------ in a browser without a network

SIZES = {"desktop": (1280, 800), "phone": (390, 844)}
OF_THE_THEME = re.compile(r"\[PST\]")
"""Notes of the theme in the console about its settings."""

WIDE = """() => [...document.querySelectorAll("article *")].filter(each => {
    for (let outer = each; outer.tagName !== "ARTICLE"; outer = outer.parentElement)
        if (["auto", "scroll", "hidden"].includes(getComputedStyle(outer).overflowX)) return false;
    return each.getBoundingClientRect().right > innerWidth + 1;
}).map(each => each.outerHTML.slice(0, 80))"""
"""What is cut off at the right, though nothing around it in the article scrolls."""


@pytest.fixture(scope="module")
def browser():
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if BROWSER is None:
        pytest.skip("no chromium on this machine")
    flags = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    with playwright.sync_playwright() as session:
        chromium = session.chromium.launch(executable_path=BROWSER, args=flags)
        yield chromium
        chromium.close()


class Visit:
    """Pages from disk, one after another, with all that they say and ask for."""

    def __init__(self, browser, size="desktop", **options):
        width, height = SIZES[size]
        context = browser.new_context(viewport={"width": width, "height": height}, offline=True, **options)
        self.page = context.new_page()
        self.logged, self.asked = [], []
        self.page.on("console", lambda message: self.logged.append(message.text))
        self.page.on("pageerror", lambda error: self.logged.append(str(error)))
        self.page.on("request", lambda request: self.asked.append(request.url))

    def open(self, name, query=""):
        self.page.goto((SITE / f"{name}.html").as_uri() + query, wait_until="load")

    def complaints(self):
        elsewhere = [url for url in self.asked if not url.startswith(("file:", "data:", "blob:", "about:"))]
        return elsewhere + [text for text in self.logged if not OF_THE_THEME.match(text)]


VISITED = [
    "index",
    "install",
    "howto",
    "forces",
    "worlds",
    "tutorials/satellite",
    "theory/canonical_quaternions",
    "generated/gallery/index",
    "generated/gallery/didymos",
    "generated/api/index",
    "generated/api/poinsot.propagate",
    "generated/api/poinsot.forces.IGRF",
    "commands",
    "generated/scenario",
    "generated/scenario_forces",
    "generated/changelog",
    "benchmarks",
    "coming_from",
    "formulas",
    "paper",
    "glossary",
    "validation",
    "cite",
]


@pytest.mark.docs
@pytest.mark.browser
@pytest.mark.parametrize("size", SIZES)
def test_pages_from_disk_are_whole_and_say_nothing(browser, size):
    visit = Visit(browser, size)
    for name in VISITED:
        visit.open(name)
        assert visit.complaints() == [], name
        assert visit.page.evaluate("document.documentElement.scrollWidth <= innerWidth"), name
        assert visit.page.evaluate(WIDE) == [], name
        missing = "[...document.images].filter(each => each.complete && !each.naturalWidth).map(each => each.src)"
        assert visit.page.evaluate(missing) == [], name


@pytest.mark.docs
@pytest.mark.browser
def test_the_search_from_disk_finds_what_propagates_an_attitude(browser):
    visit = Visit(browser)
    visit.open("search", "?q=attitude")
    visit.page.wait_for_selector("#search-results li a", timeout=20000)
    visit.page.locator("#search-results li").nth(20).wait_for(timeout=20000)
    found = visit.page.eval_on_selector_all("#search-results li a", "all => all.map(each => each.getAttribute('href'))")
    assert any(link.startswith("generated/api/poinsot.propagate.html") for link in found[:10]), found[:20]
    summaries = visit.page.locator("#search-results li p.context")
    summaries.nth(19).wait_for(timeout=20000)
    assert sum("attitude" in summary.lower() for summary in summaries.all_text_contents()) > 10
    assert visit.complaints() == []


@pytest.mark.docs
@pytest.mark.browser
@pytest.mark.parametrize("page", queries.FIRST_RESULTS)
def test_the_search_lists_the_page_of_a_query_first(browser, page):
    visit = Visit(browser)
    for query in queries.FIRST_RESULTS[page].split(", "):
        visit.open("search", f"?q={query.replace(' ', '+')}")
        visit.page.wait_for_selector("#search-results li a", timeout=20000)
        first = visit.page.eval_on_selector("#search-results li a", "link => link.getAttribute('href')")
        assert re.split(r"[?#]", first)[0] == f"{page}.html", query


@pytest.mark.docs
@pytest.mark.browser
def test_equations_are_typeset(browser):
    visit = Visit(browser)
    visit.open("theory/canonical_quaternions")
    visit.page.wait_for_selector("mjx-container svg", timeout=20000)
    assert visit.page.evaluate("document.querySelectorAll('mjx-container [data-mml-node=merror]').length") == 0
    assert visit.complaints() == []


@pytest.mark.docs
@pytest.mark.parametrize("page", sorted((ROOT / "docs" / "tutorials").glob("*.md")), ids=lambda page: page.stem)
def test_tutorials_show_the_figures_that_their_cells_draw(page):
    built = (SITE / "tutorials" / f"{page.stem}.html").read_text()
    drawing = re.findall(r"```\{code-cell\}.*?\n(.*?)```", page.read_text(), re.DOTALL)
    drawn = sum(bool(re.search(r"pt\.plot\.|plt\.subplots", cell)) for cell in drawing)
    shown = re.findall(r'<img [^>]*src="\.\./(_images/[^"]+)"', built)
    assert len(shown) >= drawn
    assert all((SITE / picture).stat().st_size > 5000 for picture in shown)


GUIDED = {
    "index": "",
    "events": "",
    "view": "",
    "generated/api/index": "",
    "generated/api/poinsot.Trajectory": "",
    "generated/gallery/index": "",
    "generated/gallery/didymos": "",
    "search": "?q=gravity+gradient",
}
"""Pages of each kind, with their queries."""
AXE = (ROOT / "tests" / "unit" / "plot" / "data" / "axe.min.js").read_text(encoding="utf-8")


@pytest.mark.docs
@pytest.mark.browser
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("size", SIZES)
def test_pages_follow_the_guidelines_for_accessibility(browser, size, scheme):
    """All rules of axe-core; the rules of embedded scenes are in the tests of their page."""
    visit = Visit(browser, size, color_scheme=scheme, bypass_csp=True)
    for name, query in GUIDED.items():
        visit.open(name, query)
        if query:
            visit.page.wait_for_selector("#search-results li .highlighted", timeout=20000)
        visit.page.evaluate(AXE)
        found = visit.page.evaluate("axe.run(document, {iframes: false})")
        violations = [(each["id"], [node["html"] for node in each["nodes"]]) for each in found["violations"]]
        assert violations == [], name
        assert len(found["passes"]) > 10


GROUND = "() => getComputedStyle(document.body).backgroundColor"


@pytest.mark.docs
@pytest.mark.browser
@pytest.mark.parametrize("page", ["view", "generated/gallery/dual_spin"])
@pytest.mark.parametrize("system", ["light", "dark"])
def test_embedded_scenes_follow_the_theme_of_the_site(browser, system, page):
    visit = Visit(browser, color_scheme=system)
    visit.open(page)
    embedded = visit.page.locator(".poinsot-view iframe")
    embedded.scroll_into_view_if_needed()
    scene = embedded.element_handle().content_frame()
    scene.wait_for_selector("#play")
    colours = {"light": "rgb(255, 255, 255)", "dark": "rgb(21, 24, 28)"}
    for theme in (system, "dark", "light", "dark"):
        if theme != system or visit.page.evaluate("document.documentElement.dataset.theme") != theme:
            visit.page.locator(".theme-switch-button:visible").click()
            visit.page.locator(f".theme-change-button[data-mode={theme}]:visible").click()
        visit.page.wait_for_timeout(300)
        assert scene.evaluate(GROUND) == colours[theme]
        assert scene.evaluate("theme.ground").lower() == {"light": "#ffffff", "dark": "#15181c"}[theme]
    assert visit.complaints() == []


@pytest.mark.docs
@pytest.mark.browser
@pytest.mark.parametrize("page", ["view", "generated/gallery/dual_spin", "generated/gallery/cubesat"])
@pytest.mark.parametrize("size", SIZES)
def test_embedded_scenes_are_whole(browser, size, page):
    """The content of the frame fits in its height and width, with both plots."""
    visit = Visit(browser, size)
    visit.open(page)
    embedded = visit.page.locator(".poinsot-view iframe")
    embedded.scroll_into_view_if_needed()
    scene = embedded.element_handle().content_frame()
    scene.wait_for_selector("#play")
    visit.page.wait_for_timeout(300)
    assert scene.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0
    assert scene.evaluate("document.documentElement.scrollHeight - innerHeight") <= 0
    boxes = scene.evaluate("[...document.querySelectorAll('#plots canvas')].map(each => each.clientHeight)")
    assert len(boxes) == 2
    assert min(boxes) > 100


@pytest.mark.docs
@pytest.mark.browser
def test_a_motion_in_the_gallery_plays_in_its_page(browser):
    visit = Visit(browser)
    visit.open("generated/gallery/dual_spin")
    visit.page.locator(".poinsot-view iframe").scroll_into_view_if_needed()
    scene = visit.page.frame_locator(".poinsot-view iframe")
    scene.locator("canvas").first.wait_for(timeout=20000)
    assert scene.get_by_role("button", name="Play").is_visible()
    assert visit.complaints() == []
