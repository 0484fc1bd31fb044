"""The page works in a real browser in every way of using it, fetches nothing, and never fails."""

import math

import pytest

import tendon_cli as tendon
from tendon_cli.reports.report import write_report
from tests.report.conftest import MOTION, TITLE, until
from tests.sampled import quick_and_torture

PAGES = ("page_file", "answer_page")
SIZES = [(390, "light"), (390, "dark"), (1280, "light"), (1280, "dark")]
ALL = [(file, *size) for file in PAGES for size in SIZES]
PAIRS = [
    ("page_file", 390, "light"),
    ("page_file", 1280, "dark"),
    ("answer_page", 390, "dark"),
    ("answer_page", 1280, "light"),
]
"""Every two of page, width and colour together; `make torture` has all three."""
REST = [case for case in ALL if case not in PAIRS]


@pytest.mark.parametrize(("file", "width", "scheme"), quick_and_torture(PAIRS, REST))
def test_it_opens_without_a_word_at_any_width_and_colour(opened, request, file, width, scheme):
    with opened(request.getfixturevalue(file), width, scheme) as page:
        if file == "page_file":
            assert page.title() == TITLE
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        assert page.locator("#map .plot-container").count() == 1


BEYOND = """(width) => {
  const scrolls = (element) => element.closest(".scroll, figure, svg, .plot, [hidden]");
  const isBeyond = (element) => {
    const box = element.getBoundingClientRect();
    return box.width > 0 && (box.right > width + 0.5 || box.left < -0.5) && !scrolls(element);
  };
  const beyond = Array.from(document.body.querySelectorAll("*")).filter(isBeyond);
  return beyond.map((element) => element.outerHTML.slice(0, 80));
}"""
"""Script that returns the elements that lie beyond a width, but for those that scroll alone."""
TOO_WIDE = """() => {
  const tables = Array.from(document.querySelectorAll(".answer .scroll"));
  const isSmall = (box) => box.querySelectorAll("tr:last-child > *").length <= 4;
  const isTooWide = (box) => isSmall(box) && box.scrollWidth > box.clientWidth;
  const isCut = (box) => isTooWide(box) || box.scrollHeight > box.clientHeight;
  return tables.filter(isCut).map((box) => box.textContent.slice(0, 80));
}"""
"""Script that returns the tables of a text that are cut below, or too wide with four columns."""


@pytest.mark.parametrize(
    "file", ["page_file", "answer_page", "people_page", "table_page", "comparison_page"]
)
def test_nothing_is_wider_than_a_phone(opened, request, file):
    with opened(request.getfixturevalue(file), 400) as page:
        assert page.evaluate("document.documentElement.scrollWidth") <= 400
        assert page.evaluate(BEYOND, 400) == []
        assert page.evaluate(TOO_WIDE) == []


def test_a_comparison_says_its_title_once(opened, comparison_page):
    with opened(comparison_page, 400) as page:
        title = page.locator("h1").inner_text()
        says = page.locator("header .says").inner_text()
        text = page.locator("body").inner_text()
        assert text.count(title) == 1
        assert text.count(says) == 1


def test_a_slider_moves_the_map(opened, page_file):
    with opened(page_file) as page:
        before = page.evaluate("JSON.stringify(Array.from(mapped.z[0]))")
        page.locator("#sliders input").fill("1")
        until(page, "before => JSON.stringify(Array.from(mapped.z[0])) !== before", before)
        assert "5 kg" in page.locator("#sliders output").inner_text()
        # The states follow, too.
        says = "document.getElementById('design-says').textContent"
        until(page, f"{says}.includes('load mass 5 kg')")


def test_a_click_shows_the_states_of_that_design(opened, page_file):
    with opened(page_file) as page:
        box = page.locator("#map .nsewdrag").first.bounding_box()
        page.mouse.click(box["x"] + 0.97 * box["width"], box["y"] + 0.03 * box["height"])
        until(page, "document.getElementById('design-says').textContent.includes('240 N')")
        assert "5 kN/m" in page.locator("#design-says").inner_text()


def test_keys_move_the_cursor_and_enter_shows_the_states(opened, page_file):
    with opened(page_file) as page:
        start = page.evaluate("cursor.i")
        right = page.evaluate("start => valueText(axisAcross(), start + 1)", start)
        page.locator("#map-frame").focus()
        for key in ("ArrowRight", "ArrowUp", "ArrowUp"):
            page.keyboard.press(key)
        assert right in page.locator("#map-says").inner_text()
        page.keyboard.press("Enter")
        until(page, "text => byId('design-says').textContent.includes(text)", right)
        outline = page.evaluate("getComputedStyle(document.activeElement).outlineStyle")
        assert outline != "none"


def test_a_quantity_without_a_value_is_mapped_and_named(opened, tmp_path):
    study = {
        "tendon": {"pretension": {"from": "60 N", "to": "240 N", "num": 5}},
        "spring": {"stiffness": ["1 kN/m", "5 kN/m"]},
        "motion": {**MOTION, "direction": ["flexion"]},
    }
    tendon.sweep(study, tmp_path / "run")
    with opened(write_report(tmp_path / "run")) as page:
        labels = page.evaluate("page.quantities.map((quantity) => quantity.label)")
        empty = page.evaluate("page.quantities.map((quantity) => quantity.low === null)")
        assert any(empty)
        for number, (label, has_none) in enumerate(zip(labels, empty, strict=True)):
            page.locator("#choosers select").first.select_option(str(number))
            until(page, "text => byId('map-says').textContent.includes(text)", f": {label}: ")
            assert ("no value" in page.locator("#map-key").inner_text()) >= has_none
        assert page.locator("#fault").inner_text() == ""


CELLS = """() => {
  const map = document.getElementById("map");
  const drawn = map.calcdata[0][0];
  const last = lengthOf(page.axes[view.x]) - 1;
  const pairs = [];
  for (const [i, j] of [[0, 0], [1, 1], [2, 2], [last, 0]]) {
    moveCursor(i, j);
    const frame = map.layout.shapes[0];
    pairs.push([frame.x0, drawn.x[cursor.i]]);
    pairs.push([frame.x1, drawn.x[cursor.i + 1]]);
    pairs.push([frame.y0, drawn.y[cursor.j]]);
    pairs.push([frame.y1, drawn.y[cursor.j + 1]]);
  }
  return pairs;
}"""
"""Script that returns edges of the cursor's frame, each with the edge of its cell as drawn."""


def test_the_cursor_frames_the_cell_as_it_is_drawn(opened, answer_page, tmp_path):
    axes = {
        "tendon": {"pretension": {"from": "60 N", "to": "240 N", "num": 4, "spacing": "log"}},
        "spool": {"ratio": [1.0, 0.7, 0.6]},
        "motion": {"elbow_angle": ["0 deg", "45 deg"]},
    }
    tendon.sweep(tendon.study(axes), tmp_path / "run")
    for file in (answer_page, write_report(tmp_path / "run")):
        with opened(file) as page:
            for framed, drawn in page.evaluate(CELLS):
                assert framed == pytest.approx(drawn, rel=1e-9)


def test_the_angle_moves_the_arm(opened, page_file):
    with opened(page_file) as page:
        before = page.locator("#arm").inner_html()
        page.locator("#angle").fill("18")
        until(page, "before => document.getElementById('arm').innerHTML !== before", before)
        assert page.locator("#angle-says").inner_text() == "90°"
        assert page.locator("#arm-values li").count() == 4


def test_the_table_sorts_and_filters(opened, page_file):
    with opened(page_file) as page:
        assert "of 126" in page.locator("#list-says").inner_text()
        page.locator("#filter").fill("load_mass = 5 kg; margin > 0 N")
        rows = page.evaluate("rowsOfTable().length")
        assert 0 < rows < 63
        page.get_by_role("button", name="margin").click()
        values = page.evaluate("rowsOfTable().map((row) => listed.columns[4].value(row))")
        assert values == sorted(values)
        page.locator("#filter").fill("colour > 3 N")
        assert "no column" in page.locator("#filter-fault").inner_text()
        assert page.evaluate("rowsOfTable().length") == rows


def test_hidden_columns_do_not_move_the_heads(opened, page_file):
    with opened(page_file) as page:
        page.evaluate("listed.columns.unshift({ name: 'first', hidden: true, value: () => 0 })")
        page.evaluate("drawTable()")
        page.get_by_role("button", name="margin").click()
        assert page.evaluate("listed.sort.name") == "margin"
        assert page.evaluate("document.activeElement.textContent").startswith("margin")


def name_of(button):
    """Return the name of a button over a figure, in lower case."""
    name = button.get_attribute("data-title") or button.get_attribute("data-attr") or ""
    return name.lower()


def test_no_button_leads_out_of_the_page(opened, page_file, answer_page):
    for file in (page_file, answer_page):
        with opened(file) as page:
            buttons = page.locator(".modebar-btn")
            for number in range(buttons.count()):
                button = buttons.nth(number)
                name = name_of(button)
                assert not any(word in name for word in ("share", "cloud", "edit in")), name
                button.dispatch_event("click")
            assert page.locator("[class*=cloud]").count() == 0
            links = page.evaluate(
                "Array.from(document.links).map((link) => link.getAttribute('href'))"
            )
            assert all(link.startswith("#") for link in links), links
            assert len(page.context.pages) == 1


def test_one_value_has_no_colour_bar(opened, tmp_path):
    axes = {
        "tendon": {"pretension": [100.0, 120.0]},
        "spool": {"flexor_radius": ["20 mm", "30 mm"]},
    }
    tendon.sweep(tendon.study(axes), tmp_path / "run")
    with opened(write_report(tmp_path / "run")) as page:
        number = page.evaluate(
            "page.quantities.findIndex((item) => !item.classes && item.low === item.high)"
        )
        page.locator("#choosers select").first.select_option(str(number))
        until(page, "document.getElementById('map').data[0].showscale === false")


def test_every_figure_has_its_table(opened, page_file):
    with opened(page_file) as page:
        for name in ("map", "states"):
            page.locator(f"#{name}-table summary").click()
            page.wait_for_selector(f"#{name}-table td")


def test_what_passes_the_filter_is_marked_by_the_keyboard(opened, answer_page):
    with opened(answer_page) as page:
        page.locator("#filter").fill("tolerance > 0.3")
        page.locator("#mark").press("Enter")
        until(page, "document.getElementById('map').data.some((trace) => trace.name === 'brushed')")
        passed = page.evaluate("rowsOfTable().length")
        assert f"{passed} choices are marked" in page.locator("#mark-says").inner_text()
        marked = page.locator("#list tr.marked")
        assert marked.count() == passed > 0
        page.locator("#filter").fill("")
        assert marked.count() == passed
        assert page.locator("#list tbody tr").count() > passed
        page.locator("#mark").press("Enter")
        assert "No choice is marked" in page.locator("#brush-says").inner_text()


def test_a_box_drawn_on_the_front_marks_choices_on_the_map(opened, answer_page):
    with opened(answer_page) as page:
        page.locator("#front").scroll_into_view_if_needed()
        box = page.locator("#front .nsewdrag").first.bounding_box()
        page.mouse.move(box["x"] + 20, box["y"] + 20)
        page.mouse.down()
        page.mouse.move(box["x"] + box["width"] - 20, box["y"] + box["height"] - 20, steps=8)
        page.mouse.up()
        until(page, "view.brushed !== null && view.brushed.length > 0")
        count = page.evaluate("view.brushed.length")
        assert f"{count} choices are marked" in page.locator("#brush-says").inner_text()
        until(page, "document.getElementById('map').data.some((trace) => trace.name === 'brushed')")


def test_persons_left_out_differ_in_shape_too(opened, answered_for_people):
    with opened(write_report(answered_for_people)) as page:
        symbols = page.evaluate(
            "document.getElementById('people').data.map((trace) => trace.marker.symbol)"
        )
        assert len(set(symbols)) == 2


def test_windows_follow_the_map(opened, answer_page):
    with opened(answer_page) as page:
        lines = page.evaluate(
            "document.getElementById('windows').data.map((trace) => trace.y.length)"
        )
        assert lines == [4, 4]
        page.locator("#choosers select").nth(1).select_option("1")
        until(page, "document.getElementById('windows').data[0].y.length === 3")


CONTRAST = """() => {
  const linear = (value) => {
    const share = value / 255;
    return share <= 0.03928 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
  };
  const luminance = (colour) => {
    const [red, green, blue] = colour.match(/[\\d.]+/g).slice(0, 3).map(Number).map(linear);
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
  };
  const behind = (element) => {
    for (let parent = element; parent; parent = parent.parentElement) {
      const colour = getComputedStyle(parent).backgroundColor;
      if (!/^rgba.*, 0\\)$/.test(colour)) {
        return colour;
      }
    }
    return "rgb(255, 255, 255)";
  };
  const contrast = (element) => {
    const text = luminance(getComputedStyle(element).color);
    const ground = luminance(behind(element));
    return (Math.max(text, ground) + 0.05) / (Math.min(text, ground) + 0.05);
  };
  const kinds = "h1, h2, p, label, a, td, th button, summary, li, output, .swatch";
  const elements = Array.from(document.querySelectorAll(kinds));
  const pairs = elements
    .filter((element) => element.textContent.trim())
    .map((element) => [contrast(element), element.textContent.slice(0, 30)]);
  return pairs.sort((first, second) => first[0] - second[0])[0];
}"""
"""Script that returns the smallest contrast of a text with its ground (WCAG 2), and that text."""


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_stands_out_from_what_is_behind_it(opened, page_file, scheme):
    with opened(page_file, scheme=scheme) as page:
        worst, text = page.evaluate(CONTRAST)
        assert worst >= 4.5, text


@pytest.mark.parametrize(("most", "is_empty"), [("50 N", True), ("900 N", False)])
def test_windows_that_are_none_are_said_to_be_none(opened, tmp_path, most, is_empty):
    study = {
        "spring": {"stiffness": ["5 kN/m", "6 kN/m"]},
        "spool": {"ratio": [0.5, 0.6]},
        "load": {"mass": ["0 kg", "10 kg"]},
        "motion": MOTION,
        "limits": {"max_tension": most},
    }
    assert tendon.design(study, tmp_path / "answer").is_negative == is_empty
    with opened(write_report(tmp_path / "answer")) as page:
        until(page, "byId('windows').querySelector('.plot-container')")
        said = page.locator("#windows").text_content()
        assert ("no choice on this line has a window" in said) == is_empty


def test_a_motion_in_time_is_shown_over_time(opened, tmp_path):
    times = [round(0.02 * sample, 2) for sample in range(100)]
    angles = [f"{50 - 30 * math.cos(math.pi * time)!r} deg" for time in times]
    motion = {"trajectory": {"time": times, "angle": angles}, "inertia": "0.08 kg m2"}
    study = {"spool": {"ratio": 0.6}, "tendon": {"pretension": "150 N"}, "motion": motion}
    swept = tendon.sweep({**study, "load": {"mass": ["0 kg", "2 kg"]}}, tmp_path / "run")
    with opened(write_report(swept), 390) as page:
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        page.locator("#groups select").select_option(label="torque")
        until(page, "byId('states').data.some((trace) => trace.name.includes('band'))")
        title = page.evaluate("byId('states').layout.xaxis.title.text")
        assert title == "time (s)"
        names = page.evaluate("byId('states').layout.shapes.map((shape) => shape.name)")
        assert "the tendons turn" in names
        before = page.evaluate("byId('states').layout.shapes[0].x0")
        page.locator("#angle").fill("80")
        until(page, "before => byId('states').layout.shapes[0].x0 !== before", before)
        assert page.locator("#angle-says").inner_text().startswith("1.6 s, ")
        turning = page.evaluate("byId('states').data.find((trace) => trace.other).other")
        inside = [at for at in range(25, 75) if math.isfinite(turning[at])]
        page.locator("#angle").fill(str(inside[0]))
        until(page, "byId('arm-values').textContent.includes('turning')")
