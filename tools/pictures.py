# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the pictures of README and documents, from the commands that they stand beside."""

import subprocess
import sys
from pathlib import Path
from shutil import copy, which
from tempfile import TemporaryDirectory

ROOT = Path(__file__).parents[1]
PICTURES = ROOT / "docs" / "pictures"
REPORT_SIZE = "900,1500"
"""Of the window, in pixels: what a reader sees of a report first."""


def heatwright(folder: Path, words: str) -> None:
    """Run a command in a folder."""
    command = [sys.executable, "-m", "heatwright.cli.start", *words.split()]
    subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)  # noqa: S603


def photographed(page: Path, picture: Path) -> None:
    """Let a browser draw a page."""
    chromium = which("chromium")
    if chromium is None:
        sys.exit("chromium is missing: sudo apt-get install chromium")
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]
    shot = [f"--screenshot={picture}", f"--window-size={REPORT_SIZE}", page.as_uri()]
    subprocess.run([chromium, *options, *shot], check=True, capture_output=True)  # noqa: S603


def main() -> None:
    """Draw the tutorial's bath, and the kiln on the first page."""
    PICTURES.mkdir(exist_ok=True)
    with TemporaryDirectory() as name:
        folder = Path(name)
        heatwright(folder, "init bath.yaml --machine sous_vide")
        spec = folder / "bath.yaml"
        text = spec.read_text("utf-8").replace("maximum: 90 °C}", "maximum: 80 °C}")
        spec.write_text(text.replace("maximum: 96 °C", "maximum: 90 °C"), "utf-8")
        heatwright(folder, f"simulate bath.yaml --plot {PICTURES}/bath.png")
        heatwright(folder, "generate bath.yaml -o bath")
        copy(folder / "bath" / "wiring.svg", PICTURES / "bath_wiring.svg")
        heatwright(folder, "verify bath.yaml --report bath.html")
        photographed(folder / "bath.html", PICTURES / "bath_report.png")
        kiln = ROOT / "spec" / "examples" / "kiln.yaml"
        heatwright(folder, f"simulate {kiln} --plot {PICTURES}/kiln.png")


if __name__ == "__main__":
    main()
