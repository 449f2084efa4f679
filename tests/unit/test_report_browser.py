"""The report in a real browser: the tooth turns and wears, readers of all kinds get along, paper shows everything.

Chromium of the system, driven by playwright, with axe-core for accessibility; skipped with the reason where one of
them is missing.
"""

import io
import re
import shutil
from itertools import combinations

import numpy as np
import pytest
from matplotlib.image import imread

import semiwear as sw
from semiwear.report import write_report

playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
axe_core = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe-playwright-python is missing")
CHROMIUM = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable"))), None
)

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed"),
]

COARSE = {
    "numerics.face_slices": 15,
    "numerics.roll_positions": 8,
    "numerics.profile_points": 41,
    "numerics.harmonics": 5,
    "numerics.wear_steps": 2,
}
USUAL = {"width": 480, "height": 900}  # small: without a graphics card every pixel is computed
PAPER_WIDTH = 703  # of A4 between margins of 12 mm, in pixels of CSS


@pytest.fixture(scope="module")
def page_file(tmp_path_factory):
    tree = sw.simulate(sw.load_scene("spur_fzg_c").replace(COARSE))
    return write_report(tree, tmp_path_factory.mktemp("browser") / "spur.html")


@pytest.fixture(scope="module")
def chromium():
    arguments = ["--no-sandbox", "--no-first-run", "--disable-background-networking"]
    arguments += ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=arguments)
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def shown(chromium, page_file):
    """The page, drawn; and what it asked for and complained of."""
    page = chromium.new_page(viewport=USUAL)
    heard = []
    page.on("request", lambda request: heard.append(request.url))
    page.on("pageerror", lambda error: heard.append(f"error: {error}"))
    page.on("console", lambda message: message.type == "error" and heard.append(f"console: {message.text}"))
    page.goto(page_file.as_uri())
    page.wait_for_selector("#turning[data-drawn=yes]", timeout=120_000)
    page.heard = heard
    assert page_file.stat().st_size < 6e6
    yield page
    page.close()


def pixels(page):
    """The view as it is seen, two frames after what was asked of it is done."""
    page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    page.wait_for_timeout(100)
    return page.locator("#turning-view").screenshot()


def put(page, control, value):
    page.locator(control).evaluate(
        "(input, value) => { input.value = value; input.dispatchEvent(new Event('input')); }", str(value)
    )


@pytest.fixture(scope="module")
def initial(shown):
    """The view that every test leaves behind."""
    return pixels(shown)


def changed_share(before, after):
    first, second = (imread(io.BytesIO(picture)) for picture in (before, after))
    return float((np.abs(first - second).max(axis=-1) > 0.05).mean())


def test_nothing_is_fetched_and_nothing_fails(shown, page_file):
    assert [one for one in shown.heard if not one.startswith("data:")] == [page_file.as_uri()]


@pytest.mark.parametrize(
    ("control", "value", "least"),
    [
        ("#turning-step", 0, 0.05),
        ("#turning-quantity", 1, 0.05),
        ("#turning-factor", 1, 1e-3),
        ("#turning-body", 1, 0.01),
        ("#turning-roll", 0, 1e-3),
    ],
)
def test_controls_change_the_picture(shown, initial, control, value, least):
    at_first = shown.locator(control).input_value()
    assert at_first != str(value)
    put(shown, control, value)
    assert changed_share(initial, pixels(shown)) > least
    put(shown, control, at_first)


@pytest.mark.parametrize("way", ["drag", "key", "button"])
def test_the_tooth_turns(shown, initial, way):
    if way == "drag":
        box = shown.locator("#turning-view").bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        shown.mouse.move(x, y)
        shown.mouse.down()
        shown.mouse.move(x + 120, y + 30, steps=2)
        shown.mouse.up()
    elif way == "key":
        shown.locator("#turning-view").focus()
        shown.keyboard.press("ArrowLeft")
    else:
        shown.get_by_role("button", name="Turn right").click()
    assert changed_share(initial, pixels(shown)) > 0.02
    shown.get_by_role("button", name="Initial view").click()
    assert changed_share(initial, pixels(shown)) < 0.01


def test_words_follow_the_sliders(shown):
    said = shown.locator("#turning-told-aloud").inner_text()
    greatest = float(re.search(r"greatest wear ([\d.]+) µm, drawn (\d+) times as deep", said)[1])
    put(shown, "#turning-step", 0)
    assert "unworn: greatest wear 0 µm" in shown.locator("#turning-told-aloud").inner_text()
    put(shown, "#turning-step", 2)
    assert greatest > 1.0 and shown.locator("#turning-told-aloud").inner_text() == said
    assert re.search(r"carries \d+ % of the load", shown.locator("#turning-where").inner_text())


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious(shown, scheme):
    shown.emulate_media(color_scheme=scheme)
    shown.evaluate("document.querySelectorAll('details').forEach(one => { one.open = true; })")
    found = axe_core.Axe().run(shown).response["violations"]
    shown.emulate_media(color_scheme="light")
    assert not [(one["id"], one["nodes"][0]["html"]) for one in found if one["impact"] in ("serious", "critical")]


@pytest.mark.parametrize("width", [390, 760, 1920])
def test_the_page_and_the_whole_tooth_fit_a_screen(shown, width):
    shown.set_viewport_size({"width": width, "height": 900})
    shown.wait_for_timeout(300)
    assert shown.evaluate("document.documentElement.scrollWidth") <= width
    view = shown.locator("#turning-view canvas").first.bounding_box()
    assert view["x"] >= 0 and view["x"] + view["width"] <= width
    beyond = shown.evaluate(
        """width => [...document.querySelectorAll("main p, main li")].filter(one => {
            const words = document.createRange();
            words.selectNodeContents(one);
            return words.getBoundingClientRect().right > width - 12;
        }).map(one => one.textContent.slice(0, 80))""",
        width,
    )
    assert not beyond
    shown.get_by_role("button", name="Initial view").click()
    picture = pixels(shown)
    words = shown.evaluate(
        """() => {
            const view = document.getElementById("turning-view").getBoundingClientRect();
            return [...document.querySelectorAll("#turning-view .annotation-text-g")].map(one => {
                const box = one.getBoundingClientRect();
                return [box.left - view.left, box.right - view.left, box.top - view.top, box.bottom - view.top,
                    view.width, view.height];
            });
        }"""
    )
    shown.set_viewport_size(USUAL)
    shown.get_by_role("button", name="Initial view").click()
    assert len(words) == 4
    for left, right, top, bottom, wide, tall in words:
        assert 0 < left < right < wide and 0 < top < bottom < tall
    for one, other in combinations(words, 2):
        assert one[1] <= other[0] or other[1] <= one[0] or one[3] <= other[2] or other[3] <= one[2]
    drawn = imread(io.BytesIO(picture))[2:-2, 2:-2, :3]  # without what lies beside the view in a broken pixel
    border = np.concatenate([drawn[:2].reshape(-1, 3), drawn[-2:].reshape(-1, 3), drawn[:, :2].reshape(-1, 3)])
    assert np.abs(border - drawn[0, 0]).max() < 0.02
    seen = np.flatnonzero(np.abs(drawn - drawn[0, 0]).max(axis=(1, 2)) > 0.1)
    assert np.ptp(seen) > 0.5 * drawn.shape[0]


def test_paper_shows_everything(shown):
    shown.evaluate("document.querySelectorAll('details').forEach(one => { one.open = false; })")
    shown.set_viewport_size({"width": PAPER_WIDTH, "height": 1000})
    shown.emulate_media(media="print")
    cut = shown.evaluate(
        """width => [...document.querySelectorAll("main *")].filter(one => {
            const box = one.getBoundingClientRect(), look = getComputedStyle(one);
            const hides = look.overflowX !== "visible" && one.scrollWidth > one.clientWidth + 1;
            return look.position !== "absolute" && (box.right > width + 1 || hides);
        }).map(one => one.outerHTML.slice(0, 80))""",
        PAPER_WIDTH,
    )
    assert not cut
    assert not shown.locator("#turning").is_visible() and shown.locator(".still img").first.is_visible()
    assert shown.locator("details pre").first.is_visible()  # what is folded away on a screen
    pages = len(re.findall(rb"/Type\s*/Page\b", shown.pdf(format="A4")))
    shown.emulate_media(media="screen")
    shown.set_viewport_size(USUAL)
    assert 4 <= pages < 40
