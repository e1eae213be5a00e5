# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the pictures of README and documents, from the commands that they stand beside."""

import subprocess
import sys
from pathlib import Path
from shutil import copy, which
from tempfile import TemporaryDirectory
from threading import Thread

from playwright.sync_api import sync_playwright

from heatwright.cli.bench.board import Board
from heatwright.cli.bench.server import Server
from heatwright.cli.firmware import build_firmware
from heatwright.cli.talk import talk
from heatwright.spec import load

ROOT = Path(__file__).parents[1]
PICTURES = ROOT / "docs" / "pictures"
Size = tuple[int, int]
REPORT_SIZE, BENCH_SIZE = (900, 1500), (1280, 1180)
"""Size of the window, in pixels: the part of a page that a reader sees first."""
FIRED_S, WATCHED_S = 3 * 3600.0, 20.0
"""How long the kiln has fired when its thermocouple chip is unplugged, and how long after that."""
COMPLETE, LIVE = "h1", "img[src*=display]"
"""What is on a page when all is: the bench's touch display is drawn last."""


def heatwright(folder: Path, words: str) -> None:
    """Run a command in a folder."""
    command = [sys.executable, "-m", "heatwright.cli.start", *words.split()]
    subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)  # noqa: S603


def photographed(address: str, picture: Path, size: Size, shows: str) -> None:
    """Let a browser draw a page; shows -- selects what is there when all is."""
    chromium = which("chromium")
    if chromium is None:
        sys.exit("chromium is missing: sudo apt-get install chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium)
        page = browser.new_page(viewport={"width": size[0], "height": size[1]})
        page.goto(address)
        page.locator(shows).first.wait_for()
        page.evaluate("Promise.all([...document.images].map((each) => each.decode()))")
        page.screenshot(path=picture)
        browser.close()


def bench(spec: Path, picture: Path) -> None:
    """Fire the kiln at the bench, unplug its thermocouple chip, and look."""
    loaded = load(spec)
    with talk() as shown:
        built = build_firmware(loaded, shown.begin("Building the kiln"))
    board = Board(loaded.controller, built.elf, loaded.file_name)
    board.set_speed(0.0)
    for order, until_s in (
        ({"do": "play"}, FIRED_S),
        ({"do": "fault", "fault": "unplugged", "on": True}, FIRED_S + WATCHED_S),
    ):
        if refused := board.do(order):
            sys.exit(refused)
        board.go_to(until_s)
    server = Server(board)
    thread = Thread(target=server.run)
    board.start()
    thread.start()
    try:
        photographed(server.address, picture, BENCH_SIZE, LIVE)
    finally:
        server.stop()
        thread.join()
        board.stop()


def main() -> None:
    """Draw the tutorial's bath, and the kiln on the first page."""
    PICTURES.mkdir(exist_ok=True)
    with TemporaryDirectory() as name:
        folder = Path(name)
        heatwright(folder, "init bath.yaml --machine sous_vide")
        spec = folder / "bath.yaml"
        text = spec.read_text("utf-8").replace("maximum: 90 °C}", "maximum: 80 °C}")
        plotter = "  - {kind: serial_plotter, loop: water, baud: 9600}\n"
        text = text.replace("\n# The machine as", f"{plotter}\n# The machine as")
        spec.write_text(text.replace("maximum: 96 °C", "maximum: 90 °C"), "utf-8")
        heatwright(folder, f"simulate bath.yaml --plot {PICTURES}/bath.png")
        heatwright(folder, "generate bath.yaml -o bath")
        copy(folder / "bath" / "wiring.svg", PICTURES / "bath_wiring.svg")
        heatwright(folder, "verify bath.yaml --report bath.html")
        page = (folder / "bath.html").as_uri()
        photographed(page, PICTURES / "bath_report.png", REPORT_SIZE, COMPLETE)
        kiln = ROOT / "spec" / "examples" / "kiln.yaml"
        heatwright(folder, f"simulate {kiln} --plot {PICTURES}/kiln.png")
        bench(kiln, PICTURES / "bench.png")


if __name__ == "__main__":
    main()
