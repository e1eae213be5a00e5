"""EEPROM of a simulated processor."""

from dataclasses import dataclass

from heatwright.sim.native.hw import Hw


@dataclass(frozen=True)
class Write:
    """A write in progress: until it ends, the byte may read as old, new, or anything."""

    address: int
    old: int
    new: int


class Eeprom:
    """The EEPROM's contents, also after a power cut."""

    def __init__(self, hw: Hw, write_s: float) -> None:
        self._ffi, self._lib, self._hw = hw.ffi, hw.lib, hw.pointer
        self._lib.hw_eeprom_write_time(self._hw, write_s)

    @property
    def size(self) -> int:
        """Size of the EEPROM, bytes."""
        return int(self._lib.hw_eeprom_size(self._hw))

    @property
    def contents(self) -> bytes:
        """All bytes, as if a write in progress were complete."""
        into = self._ffi.new("uint8_t[]", self.size)
        self._lib.hw_eeprom_get(self._hw, into)
        return bytes(self._ffi.buffer(into))

    @contents.setter
    def contents(self, image: bytes) -> None:
        """Program the EEPROM from outside; bytes beyond the image are erased (0xff)."""
        if len(image) > self.size:
            raise ValueError(f"The EEPROM has {self.size} bytes, not {len(image)}.")
        self._lib.hw_eeprom_set(self._hw, image.ljust(self.size, b"\xff"))

    @property
    def writing(self) -> Write | None:
        """The write in progress, if any."""
        address = self._ffi.new("uint16_t *")
        old, new = self._ffi.new("uint8_t *"), self._ffi.new("uint8_t *")
        busy = self._lib.hw_eeprom_writing(self._hw, address, old, new)
        return Write(address[0], old[0], new[0]) if busy else None

    def after_power_cut(self, undefined: int) -> bytes:
        """Return the contents after a power cut now; undefined: value of a half-written byte."""
        image = bytearray(self.contents)
        if self.writing:
            image[self.writing.address] = undefined
        return bytes(image)

    @property
    def writes(self) -> int:
        """Bytes written since power-on."""
        return int(self._lib.hw_eeprom_writes(self._hw))

    @property
    def violations(self) -> int:
        """Number of accesses during a write, which the part ignores."""
        return int(self._lib.hw_eeprom_violations(self._hw))
