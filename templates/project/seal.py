"""Write the checksum of a firmware into its ELF file; PlatformIO runs this after the linker.

The firmware computes the CRC of its flash from behind `flash_seal` to the end of the program, then
from 0 to the end of `flash_seal`: with the right two bytes in `flash_seal` this CRC is 0.

A program that was not built by PlatformIO is sealed by hand:

    python seal.py firmware.elf
    avr-objcopy -O ihex -R .eeprom firmware.elf firmware.hex
"""

from __future__ import annotations

import struct
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

NO_FLASH = 0x800000
"""In the linker's addresses, RAM, EEPROM and fuses begin here; flash is below."""
LOADED, SYMBOLS = 1, 2
"""The ELF types of a segment that is loaded, and of a section with symbols."""


def seal(path: Path) -> None:
    """Write the CRC to its place in an ELF file."""
    elf = path.read_bytes()
    found = list(flash(elf))
    image = bytearray(b"\xff" * max(address + size for address, _, size in found))
    for address, offset, size in found:
        image[address : address + size] = elf[offset : offset + size]
    place = symbol(elf, b"flash_seal")
    crc = crc16(image[place + 2 :] + image[:place])
    for address, offset, size in found:
        if address <= place < address + size:
            with path.open("r+b") as file:
                file.seek(offset + place - address)
                file.write(struct.pack("<H", crc))


def flash(elf: bytes) -> Iterator[tuple[int, int, int]]:
    """Find the parts that are loaded into flash: address in flash, offset in the file, size."""
    (table,), (each, count) = struct.unpack_from("<I", elf, 28), struct.unpack_from("<HH", elf, 42)
    for number in range(count):
        kind, offset, _, address, size = struct.unpack_from("<5I", elf, table + number * each)
        if kind == LOADED and size and address < NO_FLASH:
            yield address, offset, size


def symbol(elf: bytes, name: bytes) -> int:
    """Return the address of the symbol with this name."""
    (table,), (each, count) = struct.unpack_from("<I", elf, 32), struct.unpack_from("<HH", elf, 46)
    sections = [struct.unpack_from("<7I", elf, table + number * each) for number in range(count)]
    for _, kind, _, _, offset, size, names in sections:
        for entry in range(offset, offset + size, 16) if kind == SYMBOLS else ():
            word, address = struct.unpack_from("<II", elf, entry)
            start = sections[names][4] + word
            if elf[start : elf.index(0, start)] == name:
                return int(address)
    raise LookupError(f"No symbol {name.decode()}: the program was built without self-checks")


def crc16(data: bytearray) -> int:
    """Compute the CRC of Modbus, as avr-libc's `_crc16_update` does."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xA001 if crc & 1 else 0)
    return crc


def seal_target(target: list[Any], **_: object) -> None:
    """Seal the program that PlatformIO has linked."""
    seal(Path(target[0].get_abspath()))


if __name__ == "__main__":
    for each in sys.argv[1:]:
        seal(Path(each))
elif __name__ == "SCons.Script":
    from SCons.Script import DefaultEnvironment

    DefaultEnvironment().AddPostAction("$BUILD_DIR/${PROGNAME}.elf", seal_target)
