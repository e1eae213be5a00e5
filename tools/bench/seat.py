# SPDX-License-Identifier: GPL-3.0-or-later
"""The bench in a browser: from a key to the display, and a firing that is watched at full speed."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any

from measure import EXAMPLES, HEATWRIGHT, Tell, built, ran

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

KEYED, FIRED = EXAMPLES / "chamber.yaml", EXAMPLES / "kiln.yaml"
KEYS = 60
PATIENCE_MS = 600_000
DELAY = r"""
() => new Promise((done) => {
  const display = document.querySelector(".lcd");
  const shown = () => display.textContent.match(/Set temp\s+(\d+)/)?.[1];
  const before = shown();
  document.addEventListener("keydown", () => {
    const pressed_ms = performance.now();
    const seen = new MutationObserver(() => {
      if (shown() === before) return;
      seen.disconnect();
      done(performance.now() - pressed_ms);
    });
    seen.observe(display, {subtree: true, childList: true, characterData: true});
  }, {once: true, capture: true});
})
"""
"""Resolves to the time from the next key to another setpoint on the LCD, ms."""


def seat(times: int, tell: Tell, hours: float = 8.0) -> dict[str, Any]:
    """Measure both; hours -- for how long a firing is watched, in the board's time.

    It is watched, and simulated for as long, in turns; the least of each counts.
    """
    chromium_path = shutil.which("chromium")
    if find_spec("playwright") is None or chromium_path is None:
        tell("without the page: playwright or chromium is missing (make setup installs them)")
        return {}
    from playwright.sync_api import sync_playwright  # noqa: PLC0415 - only tests have it, too

    for spec in (KEYED, FIRED):
        built(spec)
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=chromium_path)
        tell(f"{KEYS} keys")
        delays_ms = pressed(chromium)
        least_s = {"watched": float("inf"), "simulated": float("inf")}  # for one hour of the board
        for turn in range(1, times + 1):
            tell(f"a firing that is watched, and simulated: {turn} of {times}")
            found_s = {"watched": watched(chromium, hours), "simulated": simulated(hours)}
            least_s = {name: min(least_s[name], found_s[name]) for name in least_s}
        chromium.close()
    return {
        "keys": KEYS,
        "key_median_ms": median(delays_ms),
        "key_most_ms": max(delays_ms),
        "hours": hours,
        "times": times,
        "watched_s": least_s["watched"],
        "simulated_s": least_s["simulated"],
    }


@contextmanager
def served(browser: Browser, spec: Path) -> Iterator[tuple[Page, subprocess.Popen[str]]]:
    """Run the command, and open its page."""
    words = [HEATWRIGHT, "bench", spec, "--json"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as process:  # noqa: S603
        try:
            assert process.stdout is not None  # noqa: S101 - it is a pipe
            address = json.loads("".join(process.stdout.readline() for _ in range(3)))["address"]
            page = browser.new_page()
            page.set_default_timeout(PATIENCE_MS)
            page.goto(address)
            page.wait_for_selector("#courses section")
            yield page, process
            page.close()
        finally:
            process.terminate()


def pressed(browser: Browser) -> list[float]:
    """Return how long each of some keys took to be seen on the display, ms."""
    with served(browser, KEYED) as (page, _):
        page.wait_for_function("/Set temp/.test(document.querySelector('.lcd').textContent)")
        page.get_by_role("button", name="▲ UP").focus()
        delays_ms = []
        for number in range(KEYS):
            page.wait_for_timeout(400 + 17 * (number % 11))  # at any time of the board's tick
            page.evaluate(f"void (window.delay = ({DELAY})())")
            page.keyboard.press("ArrowUp" if number % 2 == 0 else "ArrowDown")
            delays_ms.append(float(page.evaluate("window.delay")))
    return delays_ms


def watched(browser: Browser, hours: float) -> float:
    """Return the processor time of the command for an hour of a firing that is watched, s."""
    with served(browser, FIRED) as (page, process):
        page.click("#play")
        begun = processor_s(process.pid), clock_s(page)
        page.select_option("#speed", "full")
        while (now_s := clock_s(page)) < 3600 * hours:
            page.wait_for_timeout(100)
        return (processor_s(process.pid) - begun[0]) / (now_s - begun[1]) * 3600


def simulated(hours: float) -> float:
    """Return the same of `simulate`, without its beginning and end."""
    long, short = (
        ran((HEATWRIGHT, "simulate", FIRED, "--for", f"{for_s:.0f} s")).processor_s
        for for_s in (3600 * hours, 1)
    )
    return (long - short) / hours


def clock_s(page: Page) -> float:
    """Read the board's time off the page, s."""
    found = re.search(r"(?:(\d+):)?(\d+):(\d\d)", page.locator("#clock").inner_text())
    if found is None:
        return 0.0
    hours, minutes, seconds = (int(each or 0) for each in found.groups())
    return 3600.0 * hours + 60 * minutes + seconds


def processor_s(pid: int) -> float:
    """Return the processor time of a process so far, s."""
    told = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()
    return (int(told[11]) + int(told[12])) / os.sysconf("SC_CLK_TCK")
