"""The log by itself: a program that lets a test say what the loop reads."""

from rig.avr import Board, Program
from rig.specs import sources_of, spec_of

from heatwright.sim.elf import Elf
from heatwright.sim.interfaces.serial_log import SerialLog, attach
from heatwright.spec import SerialLog as Spec

SPEC = """
heatwright: 1
controller: {{name: logged, board: {board}}}
sensors: {{air: {{kind: ds18b20, pin: {sensor}}}}}
outputs: {{heater: {{kind: digital, pin: {heater}, power: 40 W}}}}
loops:
  air:
    {{sensor: air, heater: heater, period: 1 s, algorithm: {{kind: on_off, hysteresis: 2 K}},
     setpoint: {{initial: 10 °C, minimum: 0 °C, maximum: 70 °C}}}}
interfaces: [{{kind: serial_log, loop: air, {said}}}]
"""

MAIN = """
#include <avr/interrupt.h>
#include "clock.h"
#include "gate.h"
#include "log.h"
#include "log_port.h"
#include "loop_air.h"
#if EEPROM
#include "log_ring_eeprom.h"
#endif

struct loop_air_state loop_air;
volatile uint16_t passes;
volatile uint8_t deaf_ms; /* so that several ticks come at once */

void gate_tick(void)
{
}

int main(void)
{
#if EEPROM
    log_ring_start();
#endif
    log_port_start();
    clock_start();
    sei();
    for (;;) {
        clock_wait();
        for (; deaf_ms != 0; deaf_ms--) {
            __builtin_avr_delay_cycles(F_CPU / 1000UL);
        }
        passes++;
        log_tick();
#if EEPROM
        log_ring_tick();
#endif
    }
}
"""
PINS = {"uno": ("A1", "D3"), "mega2560": ("D22", "D6"), "atmega32": ("PA2", "PD5")}
"""Of sensor and heater, by the board."""
TICK_S = 0.01


def shown_c(celsius: float) -> float:
    """Round to what an entry holds: tenths, halves away from zero, within its 16 bits."""
    tenths = min(int(abs(celsius) * 10 + 0.5), 32767)
    return -tenths / 10 if celsius < 0 else tenths / 10


def program(said: str, board: str = "uno") -> Program:
    """Compile clock and log with the program above."""
    sensor, heater = PINS[board]
    text = SPEC.format(board=board, said=said, sensor=sensor, heater=heater)
    names = [name.removesuffix(".c") for name in sources_of(text) if name.endswith(".c")]
    chosen = [name for name in names if name.startswith(("clock", "log"))]
    kept = "log_ring_eeprom.h" in sources_of(text)
    return Program(text, tuple(chosen), MAIN, (f"-DEEPROM={int(kept)}",))


class LogBoard(Board):
    """A processor that runs it, the computer that reads it, and what it should say."""

    def __init__(self, program: Program, elf: Elf | None = None, eeprom: bytes = b"") -> None:
        """Power on; with another binary, and what is in the EEPROM, if there is."""
        self.elf = elf or program.elf()
        self._program = program
        self.controller = spec_of(program.spec).controller
        super().__init__(self.elf, self.controller.board)
        (interface,) = self.controller.interfaces
        assert isinstance(interface, Spec)
        self.interface = interface
        if eeprom:
            self.avr.eeprom.contents = eeprom
        self.computer: SerialLog = attach(self.avr, self.board, interface)
        self.avr.run(TICK_S / 2)
        self.reads(0.0)

    def with_eeprom(self, contents: bytes) -> "LogBoard":
        """Power on the same program with this in the EEPROM."""
        return LogBoard(self._program, self.elf, contents)

    def after_power_cut(self, undefined: int = 0xFF) -> "LogBoard":
        """Power it on with the EEPROM as a loss of power leaves it now."""
        return self.with_eeprom(self.avr.eeprom.after_power_cut(undefined))

    def reads(self, temperature_c: float | None, setpoint_c: float = 20.0) -> None:
        """Let the loop read this from now on; None: nothing."""
        self.put("loop_air.has_reading", 1)
        self.put("loop_air.missing", int(temperature_c is None))
        if temperature_c is not None:
            self.put("loop_air.temperature_c", temperature_c)
        self.put("loop_air.setpoint_c", setpoint_c)

    def run(self, seconds: float) -> None:
        """Go on, and let the computer hear."""
        self.avr.run(seconds)
        self.computer.feed(self.avr.pins.take(), self.avr.uarts.take())

    def ask(self, command: str, seconds: float = 1.0) -> list[str]:
        """Send a command and return the lines that came."""
        self.computer.write(command)
        self.run(seconds)
        return self.computer.texts
