// Runs flash images on avr8js, until they stay at their end; writes what their RAM then holds.
// Told on standard input as JSON: {module, images: [{flash, ram_start, ram_end, end, timer1}]},
// flash as base64, timer1: the word address of its first compare interrupt. Answers with a JSON list of the RAMs, as base64.
const fs = require("fs");
const told = JSON.parse(fs.readFileSync(0, "utf8"));
const { CPU, AVRTimer, avrInstruction, timer1Config } = require(told.module);
const MOST = 10_000_000;

function run(image) {
    const bytes = Uint8Array.from(Buffer.from(image.flash, "base64"));
    const flash = new Uint16Array(bytes.buffer);
    const cpu = new CPU(flash, image.ram_end + 1 - 0x100);
    new AVRTimer(cpu, { ...timer1Config, compAInterrupt: image.timer1 });
    while (cpu.pc !== image.end && cpu.cycles < MOST) {
        avrInstruction(cpu);
        cpu.tick();
    }
    return Buffer.from(cpu.data.subarray(image.ram_start, image.ram_end + 1)).toString("base64");
}

process.stdout.write(JSON.stringify(told.images.map(run)));
