"""A hang is told even where a boot loader clears MCUSR before the program starts."""

from powered import PowerOn

HANG_MARK = 0x5AC3
WATCHDOG_RESET = 14


def test_a_standing_main_loop_leaves_its_mark(power_on: PowerOn) -> None:
    device = power_on()
    device.advance(3.5)
    assert device.read("reset_hang_mark") == 0
    # What a boot loader leaves of a watchdog reset: RAM as it was, and no watchdog flag.
    mark = device.variables["reset_hang_mark"]
    device.avr.write_ram(mark.address, HANG_MARK.to_bytes(2, "little"))
    device.avr.reset("external")
    device.avr.run(0.05)
    assert device.read("fault.code") == WATCHDOG_RESET
    assert device.read("reset_hang_mark") == 0


def test_a_reset_without_the_mark_is_no_hang(power_on: PowerOn) -> None:
    device = power_on()
    device.advance(3.5)
    device.avr.reset("external")
    device.avr.run(0.05)
    assert device.read("fault.code") == 0


def test_the_mark_means_nothing_at_power_up(power_on: PowerOn) -> None:
    device = power_on()
    mark = device.variables["reset_hang_mark"]
    device.avr.write_ram(mark.address, HANG_MARK.to_bytes(2, "little"))
    device.avr.run(0.05)
    assert device.read("fault.code") == 0


def test_the_gate_sets_the_mark_when_the_main_loop_stands(power_on: PowerOn) -> None:
    device = power_on()
    device.advance(3.5)
    # The gate counts this permit down; a loop that stands no longer renews it.
    permit = device.variables["gate.c:main_ticks"]
    device.avr.run(0.0051)  # between two ticks
    device.avr.write_ram(permit.address, b"\x01")
    seen = []
    for _ in range(3000):
        device.avr.run(4e-6)
        seen.append(int(device.read("reset_hang_mark")))
    assert HANG_MARK in seen
    assert seen[-1] == 0, "a loop that goes on takes it back"
