"""The page in a real browser: what a hand does there, the board does, and all tabs see it."""

import json
import re
import shutil
from collections.abc import Callable, Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from pathlib import Path
from threading import Thread

import pytest
from benches import Bench, running, serving
from playwright.sync_api import Browser, Page, expect, sync_playwright

from heatwright.cli.bench.parts.lcd_keypad import Shield
from heatwright.cli.bench.server import Server
from heatwright.cli.plot.hearing import Reading
from heatwright.cli.plot.listener import Shown

CHROMIUM = shutil.which("chromium")
AXE = files("axe_playwright_python") / "axe.min.js"
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="chromium is missing: make setup")
PATIENCE_MS = 60_000
expect.set_options(timeout=PATIENCE_MS)

Open = Callable[..., Page]


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM)
        yield browser
        browser.close()


@pytest.fixture
def opened(browser: Browser) -> Iterator[Open]:
    contexts, said = [], []

    def open_page(address: str, *, scheme: str = "light", width: int = 1280) -> Page:
        context = browser.new_context(
            color_scheme=scheme,  # type: ignore[arg-type]
            viewport={"width": width, "height": 900},
            accept_downloads=True,
        )
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(PATIENCE_MS)
        page.on("console", lambda message: said.append(message.text))
        page.on("pageerror", lambda error: said.append(str(error)))
        page.goto(address)
        expect(page.locator("#courses section").first).to_be_visible()
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert said == []


@pytest.fixture(scope="module")
def chamber() -> Iterator[Bench]:
    with serving("chamber") as bench:
        yield bench


@pytest.fixture(scope="module")
def kiln() -> Iterator[Bench]:
    with serving("kiln") as bench:
        yield bench


def test_up_is_seen_on_the_display_and_in_the_chart(opened: Open, chamber: Bench) -> None:
    page = opened(chamber.address)
    lcd = page.locator(".lcd")
    expect(lcd).to_contain_text("Set temp 20")
    page.get_by_role("button", name="▲ UP").click()
    expect(lcd).to_contain_text("Set temp 30")
    chart = page.locator(".chart")
    expect(chart).to_have_attribute("aria-label", re.compile("setpoint 30.0 °C, duty 100.0 %"))
    page.get_by_role("button", name="▼ DOWN").focus()
    page.keyboard.press("Enter")  # and by the keyboard
    expect(lcd).to_contain_text("Set temp 20")
    page.keyboard.press("ArrowUp")
    expect(lcd).to_contain_text("Set temp 30")
    drawn = page.locator(".chart canvas")
    before = drawn.screenshot()
    page.keyboard.press("ArrowUp")
    expect(chart).to_have_attribute("aria-label", re.compile("setpoint 40.0 °C"))
    assert drawn.screenshot() != before


def test_of_an_interface_from_outside_the_rows_are_shown(
    opened: Open, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Shield, "kind", "from_outside")
    with serving("chamber") as bench:
        panel = opened(bench.address).get_by_role("region", name="from_outside")
        expect(panel.locator(".lcd")).to_contain_text("Set temp 20")


def test_a_pulled_sensor_is_a_fault_and_no_heat_in_every_tab(opened: Open, chamber: Bench) -> None:
    page, other = opened(chamber.address), opened(chamber.address, scheme="dark", width=400)
    page.get_by_label("unplugged").check()
    for each in (page, other):
        expect(each.locator("#fault")).to_contain_text("sensor_no_answer")
        expect(each.locator(".figures dd").last).to_have_text("0.0 %")
        expect(each.locator(".why li").first).to_contain_text("A fault is latched")
        expect(each.get_by_label("unplugged")).to_be_checked()
    other.get_by_label("unplugged").uncheck()
    expect(page.get_by_label("unplugged")).not_to_be_checked()
    board = chamber.board
    read_s = board.world.now_s + 2 * board.controller.loops["air"].period_s
    while board.world.now_s < read_s:  # until the sensor is read anew the fault comes again
        page.wait_for_timeout(100)
    page.get_by_role("button", name="SELECT").click()
    expect(other.locator("#fault")).to_be_hidden()
    expect(page.locator("#journal")).to_contain_text("fault unplugged on")


def test_time_stands_goes_on_by_a_step_and_flies(opened: Open, chamber: Bench) -> None:
    page = opened(chamber.address)
    page.get_by_role("button", name="Pause").click()
    clock = page.locator("#clock")
    expect(clock).to_contain_text("paused")
    other = opened(chamber.address)  # to which nothing new comes
    around = f"{chamber.board.world.ambient_c:g} °C"  # another test may have slid it
    expect(other.locator("#around output").first).to_have_text(around)
    stood_s = chamber.board.world.now_s
    for _ in range(3):
        page.get_by_role("button", name="Step").click()
    seconds = f"{int(round(stood_s + 3, 2)) % 60:02d}"
    expect(clock).to_contain_text(re.compile(f":{seconds} .*paused"))
    assert chamber.board.world.now_s == pytest.approx(stood_s + 3, abs=0.01)
    page.get_by_role("button", name="Run").click()
    page.select_option("#speed", "full")
    expect(clock).to_contain_text(re.compile(r"^[1-9]\d*:"))  # hours
    page.select_option("#speed", "1")


def test_m105_is_typed(opened: Open) -> None:
    with serving("extruder") as bench:
        page = opened(bench.address)
        page.get_by_label("G-code: type a line").fill("M105")
        page.keyboard.press("Enter")
        lines = page.get_by_label("G-code: lines")
        expect(lines).to_contain_text("> M105")
        expect(lines).to_contain_text("ok T:")
        page.get_by_label("G-code: type a line").press("ArrowUp")
        expect(page.get_by_label("G-code: type a line")).to_have_value("M105")


def test_a_button_of_the_touch_display_is_touched(opened: Open, kiln: Bench) -> None:
    page = opened(kiln.address)
    screen = page.locator(".screen img")
    expect(screen).to_have_attribute("alt", re.compile("^Page main: "))
    expect(screen).to_have_js_property("naturalWidth", 800)
    page.get_by_role("button", name="settings", exact=True).click()
    expect(screen).to_have_attribute("alt", re.compile("^Page settings: "))
    page.get_by_role("button", name="back", exact=True).focus()
    page.keyboard.press("Enter")
    expect(screen).to_have_attribute("alt", re.compile("^Page main: "))
    button = page.get_by_role("button", name="settings", exact=True).bounding_box()
    assert button is not None
    page.mouse.move(button["x"] + 3, button["y"] + 3)  # a finger that slides off
    page.mouse.down()
    page.mouse.move(button["x"] + 3, button["y"] - 60, steps=3)
    page.mouse.up()
    expect(screen).to_have_attribute("alt", re.compile("^Page settings: "))
    page.get_by_role("button", name="back", exact=True).click()


def test_a_register_is_written(opened: Open) -> None:
    with serving("fabricator") as bench:
        page = opened(bench.address)
        field = page.get_by_label("nozzle.setpoint, °C")
        field.fill("215")
        field.press("Enter")
        page.get_by_role("button", name="nozzle.enabled: On").click()
        row = page.locator("tr", has=page.get_by_text("nozzle.setpoint_in_force", exact=True))
        expect(row.locator("td").nth(1)).to_have_text("215")
        expect(page.locator(".leds")).to_contain_text("enabled (PB0): lit")
        field.fill("5000")
        field.press("Enter")
        expect(page.locator("#refused")).to_contain_text("out of its register's range")
        field.fill("1000")
        field.press("Enter")
        expect(page.locator(".soft[role=status]")).to_contain_text("refused nozzle.setpoint")


def test_sliders_variables_and_the_saved_scenario(
    opened: Open, chamber: Bench, tmp_path: Path
) -> None:
    page = opened(chamber.address)
    page.get_by_label("Surroundings").fill("5")
    expect(page.locator("#journal")).to_contain_text("surroundings of 5 °C")
    page.locator("#variables summary").click()
    page.locator("#variable-filter").fill("setpoint_c")
    row = page.locator("#variables tr", has=page.get_by_text("loop_air:loop_air.setpoint_c"))
    expect(row.locator("td")).to_have_text(re.compile(r"^\d+$"))
    with page.expect_download() as waiting:
        page.get_by_role("link", name="Save as a scenario").click()
    waiting.value.save_as(tmp_path / "done.yaml")
    assert "scenario:" in (tmp_path / "done.yaml").read_text("utf-8")


def test_a_chart_looks_closer_and_follows_again(opened: Open, chamber: Bench) -> None:
    page = opened(chamber.address)
    follows = page.get_by_role("button", name="10 min")
    expect(follows).to_have_attribute("aria-pressed", "true")
    box = page.locator(".u-over").bounding_box()
    assert box is not None
    middle = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + 0.6 * box["width"], middle)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.9 * box["width"], middle, steps=5)
    page.mouse.up()
    expect(follows).to_have_attribute("aria-pressed", "false")
    page.locator(".chart").focus()
    page.keyboard.press("End")
    minute = page.get_by_role("button", name="1 min", exact=True)
    minute.click()
    expect(minute).to_have_attribute("aria-pressed", "true")


HOSTILE = """<!doctype html><title>hostile</title><script>
const done = [];
const tell = (what) => {
  done.push(what);
  if (done.length === 3) document.title = done.sort().join();
};
const order = '{"do": "fault", "fault": "power_cut", "on": true}';
const line = new WebSocket("LIVE");
line.onopen = () => { line.send(order); tell("open"); };
line.onerror = () => tell("no line");
fetch("ADDRESS", {mode: "cors"}).then(() => tell("read"), () => tell("not read"));
const frame = new Image();
frame.onload = () => tell("seen");
frame.onerror = () => tell("not seen");
frame.src = "PICTURE";
</script>"""


def test_a_hostile_page_commands_nothing_even_with_the_address(
    browser: Browser, opened: Open, kiln: Bench
) -> None:
    own = opened(kiln.address).locator(".screen img")
    expect(own).to_have_js_property("naturalWidth", 800)  # there is a picture to be seen
    text = (
        HOSTILE.replace("LIVE", f"{kiln.address.replace('http', 'ws', 1)}live")
        .replace("ADDRESS", kiln.address)
        .replace("PICTURE", f"{kiln.address}display/0.png")
    )

    class Hostile(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(text.encode())

        def log_message(self, *args: object) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Hostile) as server:
        Thread(target=server.serve_forever).start()
        page = browser.new_page()
        page.goto(f"http://127.0.0.1:{server.server_port}/")
        expect(page).to_have_title("no line,not read,not seen")
        page.close()
        server.shutdown()
    assert "power_cut" not in kiln.board.scenario()


@pytest.mark.parametrize("width", [1280, 400])
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("spec", ["chamber", "kiln", "extruder", "fabricator"])
def test_axe_finds_nothing(opened: Open, spec: str, scheme: str, width: int) -> None:
    with serving(spec) as bench:
        page = opened(bench.address, scheme=scheme, width=width)
        first = next(iter(bench.board.world.breakage.causes))
        page.locator(f'input[data-fault="{first}"]').check()
        expect(page.locator("#fault")).to_be_visible()
        page.evaluate("document.querySelectorAll('details').forEach((each) => each.open = true)")
        page.evaluate(AXE.read_text("utf-8"))
        found = page.evaluate("axe.run()")["violations"]
        wrong = [(each["id"], [node["html"] for node in each["nodes"]]) for each in found]
        assert wrong == [], json.dumps(wrong, indent=1)[:3000]
        assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_a_recorded_course_is_drawn_by_the_same_chart(opened: Open) -> None:
    shown = Shown({"title": "Oven", "loop": "air", "source": "step.csv", "live": False}, "air")
    shown.tell([Reading(float(s), 20 + s / 10, 60.0, 100.0) for s in range(600)])
    with running(Server(shown)) as (server, _):
        page = opened(server.address)
        said = "air: measured 79.9 °C, setpoint 60.0 °C, duty 100.0 %"
        expect(page.locator(".chart")).to_have_attribute("aria-label", said)
        expect(page.get_by_role("button", name="all")).to_have_attribute("aria-pressed", "true")
        page.evaluate(AXE.read_text("utf-8"))
        assert page.evaluate("axe.run()")["violations"] == []
        page.close()
