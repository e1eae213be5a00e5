"""`plot`, and `identify` from a line: what a board says becomes a chart, a record, a machine."""

import json
import math
import os
import signal
import subprocess
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from itertools import count
from pathlib import Path
from shutil import copy
from threading import Event
from unittest.mock import Mock
from urllib.request import urlopen

import pytest
from rig.commands import Heatwright, changed
from rig.firmware import EXAMPLES, controller_of, finished
from rig.live import HEATWRIGHT, answered, simulated

from heatwright.cli.bench.server import Server
from heatwright.cli.plot import listener
from heatwright.cli.plot.hearing import Reading, hearing_of
from heatwright.cli.plot.listener import Shown
from heatwright.spec import registry

PLOTTER = "20.50 60.00 1.00 2.00 3.00 6.00 10.00"


def board(answer: Callable[[float], bytes]) -> AbstractContextManager[str]:
    turns = count()

    def speak(line: int, done: Event) -> None:
        if not done.wait(0.01):
            with suppress(BlockingIOError):  # nobody reads
                os.write(line, answer(next(turns)))

    return answered(speak)


@contextmanager
def ends_within(seconds: int) -> Iterator[None]:
    before = signal.signal(signal.SIGALRM, lambda *_: pytest.fail("It does not end."))
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def read(spec: str, loop: str | None, *lines: str) -> list[Reading]:
    hearing = hearing_of("spec.yaml", controller_of(spec), loop)
    return [each for line in lines for each in hearing.read(line, 7.0)]


def test_the_plotters_line_is_read() -> None:
    good = f"${PLOTTER};"
    assert read("oven", None, good, PLOTTER, "$1.00;", "noise") == [Reading(7.0, 20.5, 60.0, 100.0)]


@pytest.mark.parametrize(
    ("loop", "found"), [("hotend", (201.3, 200.0, 100.0)), ("bed", (60.1, 60.0, 0.0))]
)
def test_a_printers_report_is_read(loop: str, found: tuple[float, ...]) -> None:
    report = "ok T:201.3 /200.0 B:60.1 /60.0 @:127 B@:0"
    assert read("printer", loop, report, "ok", "start") == [Reading(7.0, *found)]


@pytest.mark.parametrize(
    ("spec", "line"),
    [
        ("extruder", "ok T:201..3 /200.0 @:127"), ("extruder", "ok T:201.3 /200.0.1 @:127"),
        ("extruder", "ok T:201.3 /200.0 @:1-7"), ("extruder", f"ok T:{'9' * 400} /200.0 @:127"),
        ("extruder", f"ok T:201.3 /200.0 @:{'9' * 400}"),
        ("oven", f"${PLOTTER.replace('20.50', 'nan')};"),
        ("oven", f"${PLOTTER.replace('20.50', '2e999')};"),
    ],
    ids=range(7),
)  # fmt: skip
def test_a_damaged_line_tells_nothing(spec: str, line: str) -> None:
    assert read(spec, None, line) == []


def answer(words: str) -> bytes:
    """A slave's answer with the checksum that its standard shows how to make (bit by bit)."""
    frame, register = bytes.fromhex(words), 0xFFFF
    for byte in frame:
        register ^= byte
        for _ in range(8):
            register = register >> 1 ^ 0xA001 * (register & 1)
    return frame + register.to_bytes(2, "little")


def told_by_modbus(*parts: bytes) -> list[Reading]:
    hearing, waiting = hearing_of("spec.yaml", controller_of("fabricator"), None), b""
    found: list[Reading] = []
    for part in parts:
        messages, waiting = hearing.cut(waiting + part)
        found += [each for text in messages for each in hearing.read(text, 7.0)]
    return found


GOOD = answer("01 04 06 07 dd 03 e8 07 d0")
READ_OF_IT = Reading(7.0, pytest.approx(201.3), 200, 100)  # type: ignore[arg-type]


def test_a_slave_is_asked_and_its_answer_has_a_gap_before_the_first_reading() -> None:
    """For temperature, duty and setpoint."""
    hearing = hearing_of("spec.yaml", controller_of("fabricator"), "nozzle")
    assert hearing.asks == answer("01 04 00 64 00 03")
    assert told_by_modbus(answer("01 04 06 80 00 00 00 01 2c")) == [Reading(7.0, None, 30, 0)]


@pytest.mark.parametrize(
    "parts",
    [(GOOD,), (GOOD[:4], GOOD[4:]), (answer("01 04 00 64 00 03"), GOOD), (b"\x01\x04\x06", GOOD)],
    ids=["whole", "in pieces", "behind an echo of what was asked", "behind a piece of another"],
)
def test_a_slaves_answer_is_read(parts: tuple[bytes, ...]) -> None:
    assert told_by_modbus(*parts, *parts) == [READ_OF_IT, READ_OF_IT]


@pytest.mark.parametrize(
    "come",
    [
        GOOD[:-1] + bytes([GOOD[-1] ^ 1]), answer("02 04 06 07 dd 03 e8 07 d0"),
        answer("01 84 02") + bytes(9), answer("01 04 08 07 dd 03 e8 07 d0 00 00"),
    ],
    ids=["damaged", "another slave's", "refused", "longer than asked for"],
)  # fmt: skip
def test_what_is_no_answer_tells_nothing(come: bytes) -> None:
    assert told_by_modbus(come, GOOD) == [READ_OF_IT]


def test_the_firmware_of_a_slave_answers() -> None:
    hearing, stop = hearing_of("spec.yaml", controller_of("fabricator"), None), Event()
    with simulated("fabricator", 1.0) as (name, _), listener.opened(name, hearing) as port:
        heard = (each for _, found in listener.heard(port, hearing, stop) for each in found)
        said = (each for each in heard if each.temperature_c != 0)  # 0: before the first reading
        told = next(said), next(said)
        stop.set()
    assert all(15 < each.temperature_c < 25 and each[2:] == (30, 0) for each in told)


def test_a_kind_from_outside_tells_how_its_line_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "from_outside").mkdir()
    (tmp_path / "from_outside" / "hearing.py").write_text(
        "from heatwright.cli.plot.gcode import hearings as all_of\n"
        "def hearings(controller, interface):\n"
        "    return [each for each in all_of(controller, interface) if each.loop == 'bed']\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(registry, "brought", lambda _: {"gcode": registry.Brought("from_outside")})
    assert read("printer", None, "ok T:201.3 /200.0 B:60.1 /60.0 @:127 B@:0")[0][1:3] == (60.1, 60)


def test_of_a_log_only_what_is_new_is_told_and_a_reset_goes_on() -> None:
    """An entry has a time, and a gap where a number is none."""
    head = "time_s,temperature_c,setpoint_c,duty_percent,program,segment"
    first, second = "60,20.4,20.0,0,,", "120,,29.0,37,1,1"
    found = read("kiln", None, head, first, "", head, first, second, "", head, first, "")
    told = (60, 20.4, 20, 0), (120, None, 29, 37), (180, 20.4, 20, 0)
    assert found == [Reading(*each) for each in told]
    lines = ("nan,20,20,0,,", "1e999,20,20,0,,", "60,1e999,20,0,,", "")
    assert read("kiln", None, *lines) == [Reading(60, None, 20, 0)]


def test_identify_records_a_line_first(heatwright: Heatwright) -> None:
    def oven(count: float) -> bytes:
        duty = 10 * (count % 8 >= 4)
        return b"$%.2f 60.00 0.00 0.00 0.00 0.00 %.2f;\r\n" % (20 + count / 10, duty)

    with board(oven) as port:
        done = heatwright(f"identify step.csv --spec oven.yaml --port {port} --for 3s --json").json
        again = heatwright(f"identify step.csv --spec oven.yaml --port {port} --for 3s", status=2)
    assert "step.csv: exists already" in again.err
    assert done["steps"]
    head, *rows = Path("step.csv").read_text().splitlines()
    assert head == "time_s,temperature_c,setpoint_c,duty_percent"
    times = {row.split(",")[0] for row in rows}  # of rows with the same time the last one counts
    assert done["readings"] == len(times) > 20
    assert {row.split(",", 2)[2] for row in rows} == {"60,0", "60,100"}
    assert "--for, how long" in heatwright(f"identify a.csv --port {port}", status=2).err


def test_a_damaged_line_does_not_end_a_recording(heatwright: Heatwright) -> None:
    reports = [b"ok T:201..3 /200.0 @:127\n", b"ok T:201.3 /200.0 @:127\n"]
    copy(EXAMPLES / "extruder.yaml", ".")
    with board(lambda count: reports[int(count) % 2]) as port:
        words = f"identify a.csv --spec extruder.yaml --port {port} --for 2s"
        assert "has the same temperature in every line" in heatwright(words, status=2).err
    assert len(Path("a.csv").read_text().splitlines()) > 3


@pytest.mark.parametrize("said", [b"", b"noise "])
def test_a_line_that_never_ends_does_not_hold_a_recording_up(
    heatwright: Heatwright, said: bytes
) -> None:
    with board(lambda _: said) as port, ends_within(60):
        found = heatwright(f"identify a.csv --spec oven.yaml --port {port} --for 0.3s", status=2)
    assert "has no rows of numbers" in found.err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--columns time,heat", "cannot have a column heat"),
        ("--columns temperature=air", "has no column air; it has time_s, temperature_c,"),
        ("--loop door", "has no loop door; there are air."),
    ],
)
def test_what_cannot_be_read_is_not_recorded(heatwright: Heatwright, words: str, said: str) -> None:
    with board(lambda _: b"$%s;\n" % PLOTTER.encode()) as port:
        line = f"identify a.csv --spec oven.yaml --port {port} --for 0.3s {words}"
        assert said in heatwright(line, status=2).err
    assert not Path("a.csv").exists()


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


def test_a_full_disk_ends_it(heatwright: Heatwright) -> None:
    del heatwright
    with board(lambda _: b"$%s;\n" % PLOTTER.encode()) as port:
        words = [HEATWRIGHT, "plot", "oven.yaml", "--port", port, "--record", "out.csv"]
        done = finished(["sh", "-c", 'ulimit -f 1; exec "$@"', "sh", *words], timeout=30)
    assert (done.returncode, done.stderr) == (2, "out.csv: cannot be written: file too large.\n")


def test_a_line_that_is_gone_at_once_ends_it(
    heatwright: Heatwright, monkeypatch: pytest.MonkeyPatch
) -> None:
    port = Mock(in_waiting=0, read=Mock(side_effect=OSError(5, "unplugged")))
    port.name = "/dev/ttyUSB9"
    monkeypatch.setattr(listener, "opened", lambda *_: nullcontext(port))
    with ends_within(60):
        found = heatwright("plot oven.yaml --port /dev/ttyUSB9", status=2)
    assert "/dev/ttyUSB9: the serial line was lost: " in found.err


@pytest.mark.parametrize("whose", ["hotend", "bed"])
def test_a_log_is_drawn_as_its_live_line(
    heatwright: Heatwright, monkeypatch: pytest.MonkeyPatch, whose: str
) -> None:
    copy(EXAMPLES / "printer.yaml", ".")
    lines = [f"ok T:{20 + at} /200.0 B:{30 + at} /60.0 @:{at} B@:{127 - at}" for at in range(9)]
    Path("host.log").write_text("\n".join(lines), encoding="utf-8")
    shown: list[Reading] = []
    monkeypatch.setattr(Server, "run", lambda _: None)
    monkeypatch.setattr(Shown, "tell", lambda _, readings: shown.extend(readings))
    assert "http://127.0.0.1:" in heatwright(f"plot printer.yaml --log host.log --loop {whose}").out
    live = [read("printer", whose, line)[0] for line in lines]
    assert [each._replace(time_s=7.0) for each in shown] == [pytest.approx(each) for each in live]
    assert [each.time_s for each in shown] == [*range(len(lines))]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("oven.yaml --port /dev/nowhere", "/dev/nowhere: cannot be opened: "),
        ("oven.yaml --loop door", "has no loop door; there are air."),
        ("oven.yaml --log a.csv --port COM3", "leave out --log, or --port and --record."),
        ("mute.yaml", "no interface sends the readings; add one"),
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


def test_its_protections_are_of_that_machine_too(heatwright: Heatwright) -> None:
    def record(resistance: float) -> None:
        def warmed_k(for_s: float) -> float:
            return 48 * resistance * (1 - math.exp(-max(0.0, for_s) / 700))

        rows = ["time_s,temperature_c,power_w"]
        for at_s in range(0, 9000, 10):
            reading_c = 25 + warmed_k(at_s - 60) - warmed_k(at_s - 4500)
            rows.append(f"{at_s},{reading_c:.4f},{48 * (60 <= at_s < 4500)}")
        Path("step.csv").write_text("\n".join(rows), encoding="utf-8")

    record(1.0)
    told = heatwright("tune oven.yaml --log step.csv --method simc --at 65C")
    assert "fault" not in told.out, "1 K/W holds 65 °C with less power than the spec's machine"
    record(0.12)
    told = heatwright("tune oven.yaml --log step.csv --method simc --at 40C")
    assert "`check` would refuse this spec:\noven.yaml:" in told.err
    assert "never to the highest setpoint" in told.err
