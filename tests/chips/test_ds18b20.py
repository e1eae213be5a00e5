"""The DS18B20 against its data sheet, by way of a plain master on a simulated processor."""

from dataclasses import replace

import pytest
from rig.firmware import SHARED, Small

from heatwright.sim.native.one_wire import Timing
from heatwright.sim.sensors.ds18b20 import CONVERSION_S, Ds18b20, crc8, raw_code, rom_code

SKIP, CONVERT, READ, WRITE, COPY, RECALL, SUPPLY = 0xCC, 0x44, 0xBE, 0x4E, 0x48, 0xB8, 0xB4
POWER_ON = bytes([0x50, 0x05, 75, 70, 0x7F, 0xFF, 0x0C, 0x10])
TIMES_US = {"reset_low": 500, "reset_sample": 70, "reset_high": 490, "one_low": 5, "zero_low": 70,
            "read_at": 10, "slot": 75}  # fmt: skip


class Master(Small):
    """Sends requests through the firmware thermometer.c."""

    def __init__(self, *, chip: bool = True, timing: Timing | None = None, **us: int) -> None:
        defines = [f"-D{time.upper()}_US={each}" for time, each in (TIMES_US | us).items()]
        super().__init__((SHARED / "thermometer.c").read_text("utf-8"), *defines)
        if chip:
            self.chip = Ds18b20(self.avr, "PC1", serial=0x123456789A, timing=timing)
        self.avr.run(0.001)

    def ask(self, *send: int, receive: int = 0) -> bytes:
        self["request.send"], self["request.receive"] = len(send), receive
        self["request.data"] = send
        done = self["request.done"]
        self["request.go"] = 1
        while self["request.done"] == done:
            self.avr.run(0.0002)
        return bytes(self["request.data"][: 8 if receive == 255 else receive])

    def scratchpad(self) -> bytes:
        return self.ask(SKIP, READ, receive=9)

    def convert(self, temperature_c: float) -> None:
        self.chip.sense(temperature_c)
        self.ask(SKIP, CONVERT)
        self.avr.run(0.8)

    @property
    def answered(self) -> bool:
        return bool(self["request.answered"] == 1)


@pytest.fixture
def master() -> Master:
    return Master()


def test_crc_of_the_application_note() -> None:
    """Maxim application note 27: the code 02 1C B8 01 00 00 00 has the CRC A2."""
    assert (crc8(bytes.fromhex("021cb801000000")), crc8(rom_code(99))) == (0xA2, 0)


CODES = {
    125: 0x07D0, 85: 0x0550, 25.0625: 0x0191, 10.125: 0x00A2, 0.5: 0x0008, 0: 0, -0.5: 0xFFF8,
    -10.125: 0xFF5E, -25.0625: 0xFE6F, -55: 0xFC90, 200: 0x07D0, -100: 0xFC90,
}  # fmt: skip


@pytest.mark.parametrize(("temperature_c", "code"), CODES.items())
def test_codes_of_the_data_sheet(temperature_c: float, code: int) -> None:
    assert raw_code(temperature_c, 12) & 0xFFFF == code


def test_bits_below_the_resolution_are_ones() -> None:
    for bits in range(9, 13):
        undefined = (1 << (12 - bits)) - 1
        assert raw_code(20.0, bits) == 320 | undefined
        assert raw_code(-20.0, bits) & undefined == undefined


def test_the_power_on_scratchpad(master: Master) -> None:
    assert master.scratchpad() == POWER_ON + bytes([crc8(POWER_ON)])
    assert (master.answered, master.chip.line.violations) == (True, 0)
    assert master.ask(SKIP, SUPPLY, receive=1) == b"\xff"  # not by the line


def test_rom_commands_select_the_chip(master: Master) -> None:
    rom = master.chip.rom
    assert (master.ask(0x33, receive=8), master.ask(0xF0, receive=255)) == (rom, rom)
    assert crc8(master.ask(0x55, *rom, READ, receive=9)) == 0
    assert master.ask(0x55, *rom_code(7), READ, receive=9) == b"\xff" * 9


def test_alarm_search_finds_it_only_beyond_its_limits(master: Master) -> None:
    for temperature_c, found in ((71.0, False), (75.0, True), (72.0, False), (70.9, True)):
        master.convert(temperature_c)
        assert (master.ask(0xEC, receive=255) == master.chip.rom) == found


@pytest.mark.parametrize("bits", [9, 10, 11, 12])
def test_a_conversion_takes_its_time(master: Master, bits: int) -> None:
    settings = [0x55, 0xAA, (bits - 9) << 5 | 0x1F]
    master.ask(SKIP, WRITE, *settings)
    master.chip.sense(50.0)
    assert master.ask(SKIP, CONVERT, receive=1) == b"\0"
    master.chip.sense(90.0)  # too late: it is taken at the start
    master.avr.run(CONVERSION_S[bits] - 0.005)
    assert master.scratchpad()[:2] == POWER_ON[:2]
    master.avr.run(0.005)
    late = master.scratchpad()
    assert int.from_bytes(late[:2], "little") == raw_code(50.0, bits)
    assert late[2:5] == bytes(settings)
    assert crc8(late) == 0


def test_read_slots_tell_when_a_conversion_is_over(master: Master) -> None:
    master.ask(SKIP, WRITE, 0, 0, 0x1F)
    assert master.ask(SKIP, CONVERT, receive=16) == bytes(16)
    master.chip.faults.slow = 0.01
    assert master.ask(SKIP, CONVERT, receive=16) == bytes(16)  # the first is still going on
    master.avr.run(0.1)
    assert master.ask(SKIP, CONVERT, receive=16)[3:] == b"\xff" * 13


def test_copy_and_recall_keep_the_settings_and_what_cannot_be_written_stays(master: Master) -> None:
    master.ask(SKIP, WRITE, 0x55, 0xAA, 0x1F)
    master.chip.brown_out()
    assert master.scratchpad()[2:5] == POWER_ON[2:5]
    master.ask(SKIP, WRITE, 0x55, 0xAA, 0x1F)
    assert master.ask(SKIP, COPY, receive=1) == b"\0"
    master.avr.run(0.011)
    master.chip.brown_out()
    assert master.scratchpad()[:5] == bytes([0x50, 0x05, 0x55, 0xAA, 0x1F])
    master.ask(SKIP, WRITE, 1, 2, 0x7F)
    master.ask(SKIP, RECALL)
    assert master.scratchpad()[2:5] == bytes([0x55, 0xAA, 0x1F])
    master.ask(SKIP, WRITE, 0x66, 0xBB)  # cut short
    assert master.scratchpad()[2:5] == bytes([0x55, 0xAA, 0x1F])
    master.ask(SKIP, WRITE, 0, 0, 0x80)  # bits of the configuration that are fixed
    assert master.scratchpad()[4] == 0x1F


def test_an_unplugged_chip_is_silent_and_starts_anew(master: Master) -> None:
    master.ask(SKIP, WRITE, 0x55, 0xAA, 0x1F)
    master.chip.unplug()
    assert (master.scratchpad(), master.answered) == (b"\xff" * 9, False)
    master.chip.plug()
    assert (master.scratchpad()[:8], master.answered) == (POWER_ON, True)


def test_a_shorted_line(master: Master) -> None:
    master.chip.short("low")
    assert master.scratchpad() == bytes(9)
    assert master.answered  # a line that stays low looks like a presence pulse ...
    assert not master["request.idle_high"]  # ... but for its being low ever after
    master.chip.short("high")
    assert (master.scratchpad(), master.answered) == (b"\xff" * 9, False)
    master.chip.short(None)
    assert master.scratchpad()[:8] == POWER_ON
    with pytest.raises(ValueError, match="shorted low or high"):
        master.chip.short("sideways")
    before = master.chip.line.resets
    for level in ("low", None):  # a short to ground that ends looks like a reset
        master.chip.short(level)
        master.avr.run(0.001)
    assert master.chip.line.resets == before + 1


def test_corrupted_reads(master: Master) -> None:
    master.chip.faults.corrupt_next = 2
    assert [bool(crc8(master.scratchpad())) for _ in range(3)] == [True, True, False]
    master.chip.faults.corrupt_rate = 0.5
    assert 10 < sum(bool(crc8(master.scratchpad())) for _ in range(40)) < 30
    again = [Ds18b20(master.avr, pin, serial=0x123456789A) for pin in ("PC2", "PC3")]
    assert again[0]._random.random() == again[1]._random.random()


def test_two_chips_on_one_line() -> None:
    """Both answer: a search finds one of them, Match ROM talks to either."""
    master = Master(chip=False)
    chips = [Ds18b20(master.avr, "PC1", serial=serial) for serial in (1, 2)]
    chips[0].sense(30.0)
    chips[1].sense(60.0)
    master.avr.run(0.001)
    master.ask(SKIP, CONVERT)
    master.avr.run(0.8)
    for chip in chips:
        data = master.ask(0x55, *chip.rom, READ, receive=9)
        assert int.from_bytes(data[:2], "little") == chip.tip.felt_c * 16


@pytest.mark.parametrize(
    "timing",
    [
        Timing(presence_wait=15, presence_low=60), Timing(presence_wait=60, presence_low=240),
        Timing(sample=15.5, hold=15), Timing(sample=59.5, hold=60),
    ],
    ids=str,
)  # fmt: skip
def test_chips_at_the_corners_of_the_data_sheet(timing: Timing) -> None:
    """The master samples presence at 70 µs, when every chip that keeps the limits is there."""
    master = Master(timing=timing)
    assert master.scratchpad()[:8] == POWER_ON
    assert (master.answered, master.chip.line.violations) == (True, 0)


def test_other_times_from_now_on(master: Master) -> None:
    master.chip.line.retime(replace(Timing(), presence_wait=80))
    master.ask(SKIP)
    assert not master.answered


@pytest.mark.parametrize(
    ("phase", "us"),
    [("reset_low", 300), ("reset_high", 300), ("one_low", 17), ("zero_low", 50), ("slot", 45),
     ("read_at", 16)],
)  # fmt: skip
def test_a_master_out_of_limits_is_noticed(phase: str, us: int) -> None:
    others = {"read_at": 20, "zero_low": 40} if phase in {"slot", "one_low"} else {}
    master = Master(**others, **{phase: us})
    master.ask(SKIP, READ, receive=2)
    line = master.chip.line
    assert line.violations >= line.phases[phase].violations > 0


def test_phases_are_measured(master: Master) -> None:
    master.scratchpad()
    phases = master.chip.line.phases
    for phase, us in (("zero_low", 70), ("one_low", 5), ("read_at", 10)):
        assert phases[phase].most == pytest.approx(us, abs=2)
    for phase, us in (("reset_low", 500), ("recovery", 5)):
        assert phases[phase].least == pytest.approx(us, abs=2)
    assert phases["reset_high"].least > 480


def test_what_a_chip_raises_comes_out_of_the_run() -> None:
    master = Master(chip=False)

    class Broken:
        def received(self, first: bool, data: bytes, cycle: int) -> None:
            raise RuntimeError(f"broken chip {first} {data!r} {cycle > 0}")

    master.avr.one_wire("PC1", Broken())
    master.avr.run(0.001)
    with pytest.raises(RuntimeError, match=r"broken chip True b'.xcc' True"):
        master.ask(SKIP)


def test_too_many_chips() -> None:
    master = Master(chip=False)
    for serial in range(8):
        Ds18b20(master.avr, "PC1", serial=serial)
    with pytest.raises(ValueError, match="too many 1-Wire chips"):
        Ds18b20(master.avr, "PC1", serial=8)
