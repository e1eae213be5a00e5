"""The simulated master: on the binary of any board, where it reads, writes by name and is refused;
and as the judge of slaves that do one thing wrong each."""

from operator import attrgetter

import numpy as np
import pytest
from rig.firmware import CLOCK_HZ, began_s, compiled, controller_of, device_of, powered, whole
from test_bare_line import slave_of

from heatwright.sim.bench import bench
from heatwright.sim.device import AvrDevice
from heatwright.sim.interfaces.modbus_rtu import ANSWER_S, ModbusMaster, frames
from heatwright.sim.interfaces.modbus_rtu.bus import Bus
from heatwright.sim.interfaces.modbus_rtu.registers import Register
from heatwright.sim.native.characters import Format
from heatwright.sim.native.pins import pin_number
from heatwright.sim.replay import replay
from heatwright.spec import BOARDS, Event

SPEC = """
heatwright: 1
controller: {{name: shape, board: {board}}}
sensors:
  air: {{kind: thermistor, pin: {sensor}, divider: {{pull_up: 4.7 kΩ}}, oversample: 4,
    curve: {{resistance: 100 kΩ, at: 25 °C, beta: 4267 K}}, range: -20 °C .. 300 °C}}
outputs:
  heater: {{kind: digital, pin: {heater}, power: 40 W}}
loops:
  air:
    {{sensor: air, heater: heater, period: 1 s, algorithm: {{kind: on_off}},
     setpoint: {{initial: 20 °C, minimum: 0 °C, maximum: 250 °C}},
     protection: {{maximum: 280 °C, minimum: -10 °C, rise_rate: 20 K/s}}}}
interfaces:
  - {{kind: modbus_rtu, baud: {baud}, parity: {parity}, driver_enable: {driver}}}
"""
# Sensor, heater, driver.
PINS = {
    **dict.fromkeys(("uno", "nano", "leonardo"), ("A1", "D3", "D2")),
    "mega2560": ("A1", "D22", "D23"),
    "atmega328p": ("PC1", "PD3", "PD2"),
    "atmega2560": ("PF1", "PA0", "PA1"),
    **dict.fromkeys(("atmega644p", "atmega1284p", "atmega32", "atmega16"), ("PA1", "PB0", "PD2")),
}
SOON_S = 0.001  # an idle slave makes its answer in less: what a control step may wait for it
RELEASED_S = 10e-6  # the interrupt behind the last stop bit, and another before it


@pytest.mark.parametrize("board", BOARDS)
@pytest.mark.parametrize(("baud", "parity"), [(1200, "odd"), (19_200, "none"), (115_200, "even")])
def test_it_answers(board: str, baud: int, parity: str) -> None:
    sensor, heater, driver = PINS[board]
    pins = {"sensor": sensor, "heater": heater, "driver": driver}
    spec = SPEC.format(board=board, baud=baud, parity=parity, **pins)
    device = device_of(spec, 30.0)
    device.advance(3.0)
    device.write("air.setpoint", 45.5)
    device.advance(6.0)
    master = device.master
    assert device.read("settings.air_setpoint_c") == 45.5
    assert device.read("loop_air.setpoint_c") == 45.5
    assert master.values["air.temperature"] == pytest.approx(30, abs=1)
    assert master.slowest_s <= SOON_S
    assert master.refusals == []
    assert (master.bus.unheard, master.bus.collisions) == (0, 0)
    assert (master.unanswered, master.strangers, master.damaged) == (0, 0, 0)
    assert 0 <= device.read("clock.c:seconds") - master.values["uptime"] <= 1
    assert device.read("clock.c:seconds") == int(6.0 - began_s(spec))
    assert master.longest_gap_s < 1.5 * master.bus.form.bits / master.bus.baud
    assert master.bus.slowest_release_s <= RELEASED_S
    assert device.read("modbus_counters.errors") == 0


def slave() -> AvrDevice:
    _, device = slave_of("dryer")
    device.advance(1.5)
    return device


def run(device: AvrDevice, seconds: float) -> None:
    device.advance(device.time_s + seconds)


def test_what_it_writes_arrives_and_it_shows_a_loop_the_change_from_off_to_on() -> None:
    device = slave()
    for name, value in {"air.setpoint": 62.5, "air.kp": 12.25, "air.manual_duty": 33.3}.items():
        device.write(name, value)
    run(device, 1.0)
    assert device.read("settings.air_setpoint_c") == 62.5
    assert device.read("settings.air_kp") == 12.25
    for _ in range(2):
        device.write("air.enabled", True)
        run(device, 1.0)
        assert device.read("loop_air.enabled") == 1
        assert device.read("modbus_counters.exceptions") == 1
    device.write("air.manual", True)
    run(device, 2.0)
    assert device.master.values["air.duty"] == pytest.approx(33.3)
    assert device.master.refusals == []
    assert not device.master.is_busy
    with pytest.raises(LookupError, match=r"no air\.responses"):
        device.write("air.responses", 1.0)


def test_it_reads_how_a_loop_has_answered() -> None:
    """Settling time and overshoot of a setpoint: as the course of the readings itself has them."""
    controller = controller_of("barrel")
    die, setpoint_c = controller.loops["die"], 60
    assert die.response is not None
    device = AvrDevice(controller, whole("barrel"))
    orders = {"die.setpoint": f"{setpoint_c} °C", "die.ki": 0.5, "die.enabled": True}
    lines = ({"at": "1 s", "write": orders}, {"for": "30 min"})
    trace = bench(controller, device, [Event.model_validate(line) for line in lines])
    log = trace.steps["die"]
    assert not replay(controller, log, "die").mismatches
    held = log[log["enabled"] == 1]
    error_k = held["temperature_c"].astype(float) - setpoint_c
    long = round(die.response.for_s / die.period_s) + 1
    near = np.abs(error_k) <= die.response.within_k
    entered = next(step for step in range(len(near)) if near[step : step + long].all())
    over_k = max(0.0, error_k[: entered + long].max())
    read = device.master.values
    assert (read["barrel.responses"], read["die.responses"]) == (0, 1)
    assert read["die.settling_time"] == entered * die.period_s > 60
    assert read["die.overshoot"] == pytest.approx(over_k, abs=0.051)
    assert over_k > 0.1


def test_a_power_cut_leaves_the_master_where_it_was() -> None:
    device = slave()
    device.unplug()
    device.power_cycle()
    run(device, 5.0)
    assert device.master.polls == 0
    device.master.plug()
    run(device, 3.0)
    assert device.master.polls > 0


BAUD = 19_200
EVEN = Format(8, "even")
MAP = {"speed": Register("input_register", 7, "speed", "i16", 0.5)}
SLAVE = """
static const uint8_t answer[] = { ANSWER };
static void put(uint8_t c) { while (!(UCSR0A & _BV(UDRE0))) {} UCSR0A |= _BV(TXC0); UDR0 = c; }
int main(void)
{
    DDRD = _BV(2);
    UBRR0 = 51; UCSR0C = 0x26; UCSR0B = _BV(RXEN0) | _BV(TXEN0);
    BEFORE
    for (;;) {
        for (uint8_t n = 0; n < 8; n++) { while (!(UCSR0A & _BV(RXC0))) {} (void)UDR0; }
        _delay_us(WAIT);
        DRIVE
        for (uint8_t n = 0; n < sizeof answer; n++) { put(answer[n]); MIDDLE }
        while (!(UCSR0A & _BV(TXC0))) {}
        RELEASE
    }
}
"""
GOOD = frames.framed(1, bytes([4, 2, 0xFF, 0xF6]))  # Minus ten steps of a half
RELEASE = "PORTD &= (uint8_t)~_BV(2);"

HARMLESS = {"WAIT": "2500", "DRIVE": "PORTD |= _BV(2);", "RELEASE": RELEASE, "MIDDLE": "",
            "BEFORE": ""}  # fmt: skip


def met(answer: bytes = GOOD, **parts: str) -> ModbusMaster:
    """A master that has polled such a slave for three and a half seconds, over RS-485."""
    parts = {"ANSWER": ", ".join(map(str, answer)), **HARMLESS, **parts}
    avr = powered(compiled(SLAVE, *(f"-D{name}={text}" for name, text in parts.items())))
    avr.pins.pull("PD2", "low")
    avr.pins.watch("PD2")
    master = ModbusMaster(avr, Bus(avr, 0, BAUD, EVEN, pin_number("PD2")), 1)
    master.serve(MAP)
    end = round(3.5 * CLOCK_HZ)
    while (wake := master.wake_cycle) is not None and wake < end:
        avr.run_to(wake)
        master.feed(avr.pins.take(), avr.uarts.take())
    return master


def test_a_good_slave_is_found_good() -> None:
    master = met()
    assert master.polls == 3
    assert master.values == {"speed": -5.0}
    assert (master.unanswered, master.strangers, master.damaged) == (0, 0, 0)
    assert (master.bus.unheard, master.bus.collisions) == (0, 0)
    assert 0 < master.bus.slowest_release_s < 10e-6
    assert master.longest_gap_s < 1.5 * EVEN.bits / BAUD
    assert 0 < master.slowest_s < 0.001


TICK_S = EVEN.bits / BAUD
WRONG = [
    GOOD[:-1] + bytes([GOOD[-1] ^ 1]), GOOD[:-1], GOOD + b"\0",
    *(frames.framed(*each) for each in (
        (2, bytes([4, 2, 0, 0])), (1, bytes([3, 2, 0, 0])), (1, bytes([0x84])),
        (1, bytes([4, 4, 0, 0, 0, 0])), (1, bytes([4, 4, 0, 0])),
    )),
]  # fmt: skip
EARLY = "PORTD &= 0xFB;"

TOO_LATE = {"WAIT": str(round(1.5e6 * ANSWER_S))}


@pytest.mark.parametrize("answer", WRONG)
def test_a_wrong_answer(answer: bytes) -> None:
    master = met(answer)
    assert (master.damaged, master.polls, master.values) == (3, 0, {})


@pytest.mark.parametrize(
    ("slave", "polls", "more_than_none"),
    [
        ({"ANSWER": "1"}, 0, "damaged"), ({"BEFORE": "UCSR0C = 0x36;"}, 0, "damaged"),
        ({"MIDDLE": "if (n == 3) _delay_us(6000);"}, 0, "damaged"),
        ({"DRIVE": "", "RELEASE": ""}, 0, "bus.unheard"),
        ({"MIDDLE": f"if (n == 6) {{ while (!(UCSR0A & _BV(UDRE0))) {{}} {EARLY} }}"}, 0,
         "bus.unheard"),
        ({"BEFORE": f"while (!(UCSR0A & _BV(RXC0))) {{}} PORTD |= _BV(2); {EARLY}"}, None,
         "bus.collisions"),
        ({"BEFORE": "_delay_ms(100); PORTD |= 4; put(1);"
                    f"while (!(UCSR0A & _BV(TXC0))) {{}} {EARLY}"}, None, "strangers"),
        (TOO_LATE, 0, "unanswered"), (TOO_LATE, 0, "strangers"),
    ],
    ids=[
        "silence", "wrong_format", "two_pieces", "driver_never_on", "driver_off_with_the_last_byte",
        "driver_on_while_the_master_sends", "unasked", "too_late", "too_late_is_a_stranger",
    ],
)  # fmt: skip
def test_what_it_does_wrong_is_counted(
    slave: dict[str, str], polls: int | None, more_than_none: str
) -> None:
    """UDRE instead of TXC lets the driver go with the last byte on its way: the classic."""
    master = met(**slave)
    assert attrgetter(more_than_none)(master) > 0
    assert polls in (None, master.polls)


@pytest.mark.parametrize(
    ("slave", "what", "seconds", "within_s"),
    [
        ({"WAIT": "2005 + 6000"}, "slowest_s", 0.006, TICK_S),
        ({"MIDDLE": "_delay_us(1200);"}, "longest_gap_s", 0.0012, TICK_S),
        ({"RELEASE": f"_delay_us(300); {RELEASE}"}, "bus.slowest_release_s", 300e-6, 1 / BAUD),
    ],
    ids=["late", "gaps", "driver_held_too_long"],
)
def test_what_takes_too_long_is_measured(
    slave: dict[str, str], what: str, seconds: float, within_s: float
) -> None:
    """Gaps may be shorter by a character: the slave has a buffer to go on from."""
    master = met(**slave)
    assert master.polls == 3
    assert attrgetter(what)(master) == pytest.approx(seconds, abs=within_s)
