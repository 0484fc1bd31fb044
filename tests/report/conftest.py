"""A headless browser, if one is installed, and pages to open in it."""

import shutil
from contextlib import contextmanager

import pytest

import tendon_cli as tendon
from tendon_cli.face import write_comparison
from tendon_cli.reports.report import write_report

BROWSER = (
    shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
)
FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
]
MOTION = {"elbow_angle": {"from": "0 deg", "to": "90 deg", "num": 19}}
TITLE = "<script>document.title = 'run'</script> & \"springs\""


def until(page, expression, arg=None):
    """Wait for an expression to be true.

    It is asked from outside, since the page's own policy lets nothing be evaluated in it.
    """
    for _ in range(300):
        if page.evaluate(expression, arg):
            return
        page.wait_for_timeout(100)
    raise AssertionError(f"never came true: {expression}")


@pytest.fixture(scope="session")
def swept(tmp_path_factory):
    """Return the folder of a run of 9 x 7 x 2 designs with a hostile title."""
    folder = tmp_path_factory.mktemp("report") / "run"
    study = {
        "title": TITLE,
        "tendon": {"pretension": {"from": "60 N", "to": "240 N", "num": 9}},
        "spring": {"stiffness": {"from": "1 kN/m", "to": "5 kN/m", "num": 7}},
        "load": {"mass": ["0 kg", "5 kg"]},
        "motion": MOTION,
    }
    tendon.sweep(study, folder)
    return folder


@pytest.fixture(scope="session")
def page_file(swept):
    return write_report(swept)


@pytest.fixture(scope="session")
def browser():
    if BROWSER is None:
        pytest.skip("no chromium is installed here")
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with playwright.sync_playwright() as engine:
        chromium = engine.chromium.launch(executable_path=BROWSER, args=FLAGS)
        yield chromium
        chromium.close()


@pytest.fixture
def opened(browser):
    """Return a context in which a file is open as a page that is ready.

    A warning or an error on the console, and any request to the network, is a failure.
    """

    @contextmanager
    def opening(path, width=1280, scheme="light"):
        page = browser.new_page(viewport={"width": width, "height": 900}, color_scheme=scheme)
        # A figure on its way into a file is a blob: it never leaves the page.
        allowed = (path.as_uri(), "blob:null/")
        faults = []

        def note_message(message):
            if message.type in ("error", "warning"):
                faults.append(message.text)

        def note_error(error):
            faults.append(str(error))

        def note_request(request):
            if not request.url.startswith(allowed):
                faults.append(request.url)

        page.on("console", note_message)
        page.on("pageerror", note_error)
        page.on("request", note_request)
        page.goto(path.as_uri())
        page.wait_for_selector("html[data-ready=yes]", timeout=60_000, state="attached")
        yield page
        assert faults == []
        page.close()

    return opening


@pytest.fixture(scope="session")
def answered(tmp_path_factory):
    """Return the folder of an answer on 4 x 3 choices under two loads, with a front."""
    folder = tmp_path_factory.mktemp("answer") / "suit-design"
    study = {
        "spring": {"stiffness": {"from": "2 kN/m", "to": "8 kN/m", "num": 4}},
        "spool": {"ratio": [0.5, 0.6, 1]},
        "load": {"mass": ["0 kg", "5 kg"]},
        "motion": MOTION,
        "design": {"minimise": ["max_tension"], "maximise": ["tolerance"]},
    }
    tendon.design(study, folder)
    return folder


@pytest.fixture(scope="session")
def answer_page(answered):
    return write_report(answered)


@pytest.fixture(scope="session")
def answered_for_people(tmp_path_factory):
    """Return the folder of an answer on two choices and sixty persons."""
    folder = tmp_path_factory.mktemp("people") / "suit-design"
    study = {
        "people": {"count": 60},
        "spring": {"stiffness": "5 kN/m"},
        "spool": {"ratio": [0.6, 0.7]},
        "load": {"mass": ["0 kg", "10 kg"]},
        "motion": MOTION,
        "design": {"serve": 0.5, "verify": 500},
    }
    tendon.design(study, folder)
    return folder


@pytest.fixture(scope="session")
def people_page(answered_for_people):
    return write_report(answered_for_people)


@pytest.fixture(scope="session")
def table_page(tmp_path_factory):
    """Return the page of an answer on rows of a table with long names."""
    folder = tmp_path_factory.mktemp("table") / "suit-design"
    rows = [
        {"name": f"prototype with a long name, number {row}", "spring.stiffness": f"{row} kN/m"}
        for row in (4, 5, 8)
    ]
    study = {"table": [{"name": "prototype", "rows": rows}], "spool": {"ratio": 0.6}}
    tendon.design(study | {"load": {"mass": ["0 kg", "5 kg"]}, "motion": MOTION}, folder)
    return write_report(folder)


@pytest.fixture(scope="session")
def comparison_page(answered, answered_for_people, tmp_path_factory):
    """Return the page that compares an answer for persons with another one."""
    file = tmp_path_factory.mktemp("comparison") / "page.html"
    write_comparison(tendon.compare(answered_for_people, answered), file)
    return file
