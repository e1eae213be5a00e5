// Runs a whole firmware on avr8js, with its timers, USART, ADC and watchdog, and says what it did.
// Told on standard input as JSON: {module, flash (base64), ram_end, clock_hz, cycles,
// vectors: {watchdog, timer1, timer2, usart, adc}: word addresses of the first of each,
// ports: [letters], high: [[port, bit]], volts: [of each ADC channel],
// counter: {address, size}, ram: {address, size}}.
// Answers with {pins: [[port, bit, "low" | "high" | "in"]], sent: [bytes], images: [base64],
// resets}: each change at a pin, and the RAM at the first SLEEP after each change of the counter.
const fs = require("fs");
const told = JSON.parse(fs.readFileSync(0, "utf8"));
const avr = require(told.module);
const SLEEP = 0x9588;
const NAMES = { 0: "low", 1: "high", 2: "in", 3: "in" };

const bytes = Uint8Array.from(Buffer.from(told.flash, "base64"));
const flash = new Uint16Array(bytes.buffer);
const cpu = new avr.CPU(flash, told.ram_end + 1 - 0x100);
cpu.data[0x54] = 1;  // MCUSR: power-on, which avr8js does not say
const found = { pins: [], sent: [], images: [], resets: 0 };

function moved(config, first, names) {
    return { ...config, ...Object.fromEntries(names.map((name, n) => [name, first + 2 * n])) };
}

const { vectors } = told;
const matches = ["compAInterrupt", "compBInterrupt"];
new avr.AVRTimer(cpu, moved(avr.timer1Config, vectors.timer1, matches));
new avr.AVRTimer(cpu, moved(avr.timer2Config, vectors.timer2, matches));
new avr.AVREEPROM(cpu, new avr.EEPROMMemoryBackend(0x1000));
const clock = new avr.AVRClock(cpu, told.clock_hz);
new avr.AVRWatchdog(cpu, moved(avr.watchdogConfig, vectors.watchdog, ["watchdogInterrupt"]), clock);
const usart = new avr.AVRUSART(cpu, moved(avr.usart0Config, vectors.usart,
    ["rxCompleteInterrupt", "dataRegisterEmptyInterrupt", "txCompleteInterrupt"]), told.clock_hz);
usart.onByteTransmit = (value) => found.sent.push(value);
const adc = new avr.AVRADC(cpu, moved(avr.adcConfig, vectors.adc, ["adcInterrupt"]));
told.volts.forEach((volts, channel) => { adc.channelValues[channel] = volts; });
const ports = Object.fromEntries(told.ports.map((letter) => {
    const port = new avr.AVRIOPort(cpu, avr[`port${letter}Config`]);
    const before = Array(8).fill("in");
    port.addListener(() => before.forEach((was, bit) => {
        const now = NAMES[port.pinState(bit)];
        if (now !== was) {
            before[bit] = now;
            found.pins.push([letter, bit, now]);
        }
    }));
    return [letter, port];
}));
told.high.forEach(([letter, bit]) => ports[letter].setPin(bit, true));
const reset = cpu.reset.bind(cpu);
cpu.reset = () => {
    found.resets += 1;
    for (const { portConfig } of Object.values(ports)) {  // avr8js leaves all registers as they were
        cpu.writeData(portConfig.DDR, 0);
        cpu.writeData(portConfig.PORT, 0);
    }
    reset();
};

function bytesOf({ address, size }) {
    return Buffer.from(cpu.data.subarray(address, address + size)).toString("base64");
}

let counter = bytesOf(told.counter);
while (cpu.cycles < told.cycles) {
    if (flash[cpu.pc] === SLEEP) {
        const now = bytesOf(told.counter);
        if (now !== counter) {
            counter = now;
            found.images.push(bytesOf(told.ram));
        }
        // avr8js takes SLEEP for NOP: here time goes on to what happens next.
        if (cpu.nextInterrupt < 0 && cpu.nextClockEvent) {
            cpu.cycles = Math.max(cpu.cycles, cpu.nextClockEvent.cycles);
        }
    }
    avr.avrInstruction(cpu);
    cpu.tick();
}
process.stdout.write(JSON.stringify(found));
