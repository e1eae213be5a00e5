"""`plot`, and `identify` from a line: what a board says becomes a chart, a record, a machine."""

import json
import os
import pty
import signal
import subprocess
import sys
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Event, Thread
from urllib.request import urlopen

import pytest
from rig.commands import Heatwright, changed
from rig.specs import controller_of

from heatwright.cli.plot.hearing import Reading, hearing_of

HEATWRIGHT = Path(sys.executable).parent / "heatwright"
PLOTTER = "20.50 60.00 1.00 2.00 3.00 6.00 10.00"


@contextmanager
def board(answer: Callable[[float], bytes], every_s: float = 0.01) -> Iterator[str]:
    """A line at whose other end something speaks; gives its name."""
    ours, theirs = pty.openpty()
    tty.setraw(theirs)
    done = Event()

    def speak() -> None:
        count = 0
        while not done.wait(every_s):
            os.write(ours, answer(count))
            count += 1

    thread = Thread(target=speak)
    thread.start()
    try:
        yield os.ttyname(theirs)
    finally:
        done.set()
        thread.join()
        os.close(ours)
        os.close(theirs)


def read(spec: str, loop: str | None, *lines: str) -> list[Reading]:
    hearing = hearing_of("spec.yaml", controller_of(spec), loop)
    return [each for line in lines for each in hearing.read(line, 7.0)]


def test_the_plotters_line_is_read() -> None:
    good = f"${PLOTTER};"
    assert read("oven", None, good, PLOTTER, "$1.00;", "noise") == [Reading(7.0, 20.5, 60.0, 100.0)]


@pytest.mark.parametrize(
    ("loop", "found"),
    [("hotend", (201.3, 200.0, 100.0)), ("bed", (60.1, 60.0, 0.0))],
)
def test_a_printers_report_is_read(loop: str, found: tuple[float, ...]) -> None:
    report = "ok T:201.3 /200.0 B:60.1 /60.0 @:127 B@:0"
    assert read("printer", loop, report, "ok", "start") == [Reading(7.0, *found)]


def test_of_a_log_only_what_is_new_is_told_and_a_reset_goes_on() -> None:
    head = "time_s,temperature_c,setpoint_c,duty_percent,program,segment"
    first, second = "60,20.4,20.0,0,,", "120,,29.0,37,1,1"
    found = read("kiln", None, head, first, "", head, first, second, "", head, first, "")
    assert found == [
        Reading(60, 20.4, 20, 0),
        Reading(120, None, 29, 37),
        Reading(180, 20.4, 20, 0),
    ]


def test_identify_records_a_line_first(heatwright: Heatwright) -> None:
    def oven(count: float) -> bytes:
        duty = 10 * (count % 60 >= 30)
        return b"$%.2f 60.00 0.00 0.00 0.00 0.00 %.2f;\r\n" % (20 + count / 10, duty)

    with board(oven) as port:
        done = heatwright(f"identify step.csv --spec oven.yaml --port {port} --for 1s --json").json
        again = heatwright(f"identify step.csv --spec oven.yaml --port {port} --for 1s", status=2)
    assert "step.csv: is there already" in again.err
    assert done["readings"] > 20
    assert done["steps"]
    head, *rows = Path("step.csv").read_text().splitlines()
    assert head == "time_s,temperature_c,setpoint_c,duty_percent"
    assert {row.split(",", 2)[2] for row in rows} == {"60,0", "60,100"}
    assert "--for how long" in heatwright(f"identify a.csv --port {port}", status=2).err


def test_it_serves_and_records_until_ctrl_c(heatwright: Heatwright) -> None:
    with board(lambda _: b"$%s;\n" % PLOTTER.encode()) as port:
        words = [HEATWRIGHT, "plot", "oven.yaml", "--port", port, "--record", "out.csv", "--json"]
        with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout is not None
            told = json.loads("".join(process.stdout.readline() for _ in range(3)))
            with urlopen(told["address"], timeout=60) as page:  # noqa: S310 - the address is ours
                assert "<title>Plot</title>" in page.read().decode()
            while Path("out.csv").stat().st_size < 200:
                assert process.poll() is None
            process.send_signal(signal.SIGINT)
            assert process.wait(timeout=60) == 0
    assert Path("out.csv").read_text().splitlines()[1].endswith(",20.5,60,100")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("oven.yaml --port /dev/nowhere", "/dev/nowhere: cannot be opened: "),
        ("oven.yaml --loop door", "has no loop door; there are air."),
        ("oven.yaml --log a.csv --port COM3", "leave out --port and --record, or it."),
        ("mute.yaml", "no line tells the course; add an interface"),
    ],
)
def test_what_cannot_be_is_told(heatwright: Heatwright, words: str, said: str) -> None:
    Path(changed("oven", "  - {kind: serial_plotter, loop: air, baud: 9600, line_end: CR LF}", ""))
    Path("changed.yaml").rename("mute.yaml")
    assert said in heatwright(f"plot {words}", status=2).err


def test_tune_takes_the_machine_of_a_log(heatwright: Heatwright) -> None:
    heatwright("simulate oven.yaml --model --csv run.csv")
    own = heatwright("tune oven.yaml --method simc --json").json["loops"]["air"]
    found = heatwright("tune oven.yaml --method simc --log run.csv --json").json["loops"]["air"]
    assert found["chosen"] == "simc"
    assert found["model"] != own["model"]
    several = changed("printer", "heatwright: 1", "heatwright: 1")
    assert "has several loops" in heatwright(f"tune {several} --log run.csv", status=2).err
