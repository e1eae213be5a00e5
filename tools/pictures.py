# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the pictures of README and documents, from the commands that they stand beside."""

import json
import re
import subprocess
import sys
from io import StringIO
from pathlib import Path
from shutil import copy, which
from tempfile import TemporaryDirectory
from threading import Thread

from playwright.sync_api import sync_playwright
from rich.console import Console
from rich.syntax import Syntax

from heatwright.cli.bench.board import Board
from heatwright.cli.bench.server import Server
from heatwright.cli.firmware import build_firmware
from heatwright.cli.talk import talk
from heatwright.spec import load

ROOT = Path(__file__).parents[1]
PICTURES = ROOT / "docs" / "pictures"
Size = tuple[int, int]
REPORT_SIZE, BENCH_SIZE, PLOT_SIZE = (900, 1500), (1280, 1180), (1000, 620)
"""Size of the window, in pixels: the part of a page that a reader sees first."""
FIRED_S, WATCHED_S = 3 * 3600.0, 20.0
"""How long the kiln has fired when its thermocouple chip is unplugged, and how long after that."""
FONT = re.compile(r"\s*@font-face \{.*?\}", re.DOTALL)
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


def exported(console: Console, title: str) -> str:
    """Return what a terminal shows as a drawing that fetches no fonts from elsewhere."""
    return FONT.sub("", console.export_svg(title=title))


def terminal(folder: Path, picture: Path, *lines: str) -> None:
    """Run commands, and draw what a terminal of 100 columns shows of them."""
    told = []
    for words in lines:
        command = [sys.executable, "-m", "heatwright.cli.start", *words.split()]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)  # noqa: S603
        told.append(f"$ heatwright {words}\n{done.stdout}{done.stderr if done.returncode else ''}")
    console = Console(record=True, width=100, file=StringIO())
    console.print("".join(told).rstrip(), highlight=False, markup=False, overflow="fold")
    picture.write_text(exported(console, "a terminal"), encoding="utf-8")


def edited(spec: Path, picture: Path) -> None:
    """Draw the part of a spec that becomes firmware, as an editor shows it."""
    text = spec.read_text("utf-8").split("\n# The machine for")[0]
    console = Console(record=True, width=120, file=StringIO())
    console.print(Syntax(text, "yaml", theme="ansi_dark", line_numbers=True, word_wrap=True))
    picture.write_text(exported(console, spec.name), encoding="utf-8")


def plotted(folder: Path, picture: Path) -> None:
    """Look at a recorded course on the page of `plot`."""
    words = ["plot", "bath.yaml", "--log", "step.csv", "--json"]
    command = [sys.executable, "-m", "heatwright.cli.start", *words]
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True) as process:  # noqa: S603
        assert process.stdout is not None  # noqa: S101 - it is a pipe
        address = json.loads("".join(process.stdout.readline() for _ in range(3)))["address"]
        photographed(address, picture, PLOT_SIZE, ".chart canvas")
        process.terminate()


def main() -> None:
    """Draw the tutorial's bath, and the kiln on the first page."""
    PICTURES.mkdir(exist_ok=True)
    with TemporaryDirectory() as name:
        folder = Path(name)
        heatwright(folder, "init bath.yaml --machine sous_vide")
        spec = folder / "bath.yaml"
        text = spec.read_text("utf-8").replace("maximum: 90 °C}", "maximum: 80 °C}")
        plotter = "  - {kind: serial_plotter, loop: water, baud: 9600}\n"
        text = text.replace("\n# The machine for", f"{plotter}\n# The machine as")
        hot = spec.read_text("utf-8").replace("maximum: 96 °C", "maximum: 90 °C")
        edited(spec, PICTURES / "bath_spec.svg")
        spec.write_text(hot, "utf-8")
        terminal(folder, PICTURES / "bath_check.svg", "check bath.yaml")
        spec.write_text(text.replace("maximum: 96 °C", "maximum: 90 °C"), "utf-8")
        heatwright(folder, f"simulate bath.yaml --plot {PICTURES}/bath.png")
        heatwright(folder, "generate bath.yaml -o bath")
        copy(folder / "bath" / "wiring.svg", PICTURES / "bath_wiring.svg")
        heatwright(folder, "verify bath.yaml --report bath.html")
        page = (folder / "bath.html").as_uri()
        photographed(page, PICTURES / "bath_report.png", REPORT_SIZE, COMPLETE)
        heatwright(folder, "simulate bath.yaml --csv step.csv")
        plotted(folder, PICTURES / "bath_plot.png")
        fitted = f"--cold --plot {PICTURES}/bath_identify.png"
        heatwright(folder, f"identify step.csv --spec bath.yaml {fitted}")
        kiln = ROOT / "spec" / "examples" / "kiln.yaml"
        heatwright(folder, f"simulate {kiln} --plot {PICTURES}/kiln.png --display kiln_display.png")
        copy(folder / "kiln_display.png", PICTURES)
        bench(kiln, PICTURES / "bench.png")


if __name__ == "__main__":
    main()
