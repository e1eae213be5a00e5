// SPDX-License-Identifier: GPL-3.0-or-later
// Runs a flash image for an ATmega328P on avr8js; prints the processor time of its loop, s.
// Told on standard input as JSON: {module, flash (base64), clock_hz, cycles}.
const fs = require("fs");
const told = JSON.parse(fs.readFileSync(0, "utf8"));
const avr = require(told.module);
const SLEEP = 0x9588;

const bytes = Uint8Array.from(Buffer.from(told.flash, "base64"));
const flash = new Uint16Array(bytes.buffer);
const cpu = new avr.CPU(flash, 0x0900 - 0x100);
for (const config of [avr.timer0Config, avr.timer1Config, avr.timer2Config]) {
    new avr.AVRTimer(cpu, config);
}
for (const config of [avr.portBConfig, avr.portCConfig, avr.portDConfig]) {
    new avr.AVRIOPort(cpu, config);
}
new avr.AVREEPROM(cpu, new avr.EEPROMMemoryBackend(0x400));
const clock = new avr.AVRClock(cpu, told.clock_hz);
new avr.AVRWatchdog(cpu, avr.watchdogConfig, clock);
new avr.AVRUSART(cpu, avr.usart0Config, told.clock_hz);
new avr.AVRADC(cpu, avr.adcConfig);

const before = process.cpuUsage();
while (cpu.cycles < told.cycles) {
    // avr8js takes SLEEP for NOP: here time goes on to what happens next.
    if (flash[cpu.pc] === SLEEP && cpu.nextInterrupt < 0 && cpu.nextClockEvent) {
        cpu.cycles = Math.max(cpu.cycles, cpu.nextClockEvent.cycles);
    }
    avr.avrInstruction(cpu);
    cpu.tick();
}
const { user, system } = process.cpuUsage(before);
console.log((user + system) / 1e6);
