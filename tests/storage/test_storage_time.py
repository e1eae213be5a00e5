"""Nothing waits for the EEPROM: it is read and written when it is ready, and only then."""

import pytest
from storage_firing import Firing, FiringByKeys, machine
from storage_verdict import Book
from storage_waits import waiting, waits_problem

ROWS = 1500
WAIT_S = 100e-6
TICK_S = 0.01
ACCESS = ("eeprom_read_byte", "eeprom_write_byte")


@pytest.mark.parametrize(("example", "firing_of"), [("kiln", Firing), ("kiln_uno", FiringByKeys)])
def test_no_access_waits_for_another(example, firing_of, monkeypatch):
    controller, program = machine(example)
    firing = firing_of(controller, program, 5, Book(controller).record)
    monkeypatch.setattr(firing, "lose_power", lambda: None)  # a profile is of one processor
    avr = firing.device.avr
    profile = avr.profile(program)
    for row in range(ROWS):
        list(firing.cuts(1, busy=0.0, quiet=0.0))
        if example == "kiln" and row % 3 == 0:
            firing.device.send(f"#13 {1 + row % 9 // 3};")
    functions = profile.functions
    assert avr.eeprom.writes > 300
    assert avr.eeprom.violations == 0
    for name in ACCESS:
        assert functions[name].calls > 300
        assert functions[name].longest < WAIT_S * avr.clock_hz
    longest = {name: functions[name].longest for name in ("progress_tick", "programs_tick")}
    assert max(longest.values()) < TICK_S / 10 * avr.clock_hz


@pytest.mark.parametrize("machine", ["few", "typed"])
def test_nor_where_all_want_to_write_at_once(machine):
    assert waits_problem(machine, waiting(machine).elf()) == ""
