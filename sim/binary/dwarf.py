"""A program's variables, found by their names in its debug information.

``Variables(elf)["loop_air.temperature_c"]`` gives address, size and numpy type; structures are
entered with dots, array elements with ``[n]``. Names that two source files share (static variables)
are distinguished by the file: ``"control.c:state"``. A series of RAM images is decoded at once::

    table = variables.decode(images, base, ["loop_air", "fault.code"])
    table["loop_air"]["temperature_c"]      # float32, one per image
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from elftools.elf.elffile import ELFFile
from numpy.typing import NDArray

from heatwright.sim.binary.elf import RAM, Elf, ElfError

_BOOLEAN = 0x02
_FLOAT = 0x04
_SIGNED = {0x05, 0x06}
_TRANSPARENT = {"DW_TAG_typedef", "DW_TAG_const_type", "DW_TAG_volatile_type"}


class Types:
    """Converts DWARF types to numpy types, each only once."""

    def __init__(self) -> None:
        self._known: dict[int, np.dtype[Any]] = {}

    def dtype(self, die: Any) -> np.dtype[Any]:
        """Return the numpy type for the entry's DW_AT_type."""
        if "DW_AT_type" not in die.attributes:
            return np.dtype("V0")
        kind = die.get_DIE_from_attribute("DW_AT_type")
        if kind.offset not in self._known:
            self._known[kind.offset] = self._make(kind)
        return self._known[kind.offset]

    def _make(self, kind: Any) -> np.dtype[Any]:
        if kind.tag in _TRANSPARENT:
            return self.dtype(kind)
        if kind.tag == "DW_TAG_array_type":
            return self._array(kind)
        if kind.tag in {"DW_TAG_structure_type", "DW_TAG_union_type"}:
            return self._structure(kind)
        return _base(kind)

    def _array(self, kind: Any) -> np.dtype[Any]:
        shape = tuple(
            _count(child) for child in kind.iter_children() if child.tag == "DW_TAG_subrange_type"
        )
        return np.dtype((self.dtype(kind), shape))

    def _structure(self, kind: Any) -> np.dtype[Any]:
        members = [
            child
            for child in kind.iter_children()
            if child.tag == "DW_TAG_member" and "DW_AT_bit_size" not in child.attributes
        ]
        return np.dtype(
            {
                "names": [_label(member, place) for place, member in enumerate(members)],
                "formats": [self.dtype(member) for member in members],
                "offsets": [_offset(member) for member in members],
                "itemsize": _size(kind),
            }
        )


def _size(kind: Any) -> int:
    found = kind.attributes.get("DW_AT_byte_size")
    return int(found.value) if found else 0


def _base(kind: Any) -> np.dtype[Any]:
    size = _size(kind)
    if kind.tag == "DW_TAG_pointer_type":
        return np.dtype("<u2")
    encoding = kind.attributes["DW_AT_encoding"].value if kind.tag == "DW_TAG_base_type" else 0
    if encoding == _BOOLEAN and size == 1:
        return np.dtype("?")
    if encoding == _FLOAT:
        return np.dtype(f"<f{size}")
    return np.dtype(f"<{'i' if encoding in _SIGNED else 'u'}{size}")


def _count(subrange: Any) -> int:
    if "DW_AT_count" in subrange.attributes:
        return int(subrange.attributes["DW_AT_count"].value)
    bound = subrange.attributes.get("DW_AT_upper_bound")
    return int(bound.value) + 1 if bound and isinstance(bound.value, int) else 0


def _offset(member: Any) -> int:
    found = member.attributes.get("DW_AT_data_member_location")
    if found is None:
        return 0
    if isinstance(found.value, int):
        return int(found.value)
    return _uleb(found.value[1:])  # DW_OP_plus_uconst, as DWARF 2 writes it


def _uleb(data: list[int]) -> int:
    return sum((byte & 0x7F) << 7 * place for place, byte in enumerate(data))


def _label(member: Any, place: int) -> str:
    found = member.attributes.get("DW_AT_name")
    return str(found.value.decode()) if found else f"unnamed_{place}"


_OP_ADDR = 0x03
_PATH = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*|\[\d+\])*")
_STEP = re.compile(r"\.?([A-Za-z_]\w*)|\[(\d+)\]")


@dataclass(frozen=True)
class Variable:
    """A variable: its RAM address and its numpy type (``dtype.itemsize`` bytes)."""

    name: str
    address: int
    dtype: np.dtype[Any]

    @property
    def size(self) -> int:
        """Size of the variable, bytes."""
        return int(self.dtype.itemsize)

    def step(self, member: str) -> Variable:
        """Return a member of this structure. Raises ElfError: it has none of that name."""
        fields = self.dtype.fields
        if fields is None or member not in fields:
            have = ", ".join(fields or ()) or "no members"
            raise ElfError(f"{self.name} has no member {member} (it has {have}).")
        dtype, offset = fields[member][:2]
        return Variable(f"{self.name}.{member}", self.address + offset, dtype)

    def element(self, index: int) -> Variable:
        """Return an element of this array. Raises ElfError: it is no array, or is shorter."""
        if self.dtype.subdtype is None or index >= self.dtype.subdtype[1][0]:
            raise ElfError(f"{self.name} has no element {index}.")
        base, shape = self.dtype.subdtype
        dtype = np.dtype((base, shape[1:])) if shape[1:] else base
        return Variable(f"{self.name}[{index}]", self.address + index * dtype.itemsize, dtype)


@lru_cache(maxsize=8)
def _described(program: bytes) -> Mapping[str, list[Variable]]:
    """Read the variables' debug information; cached, as this takes a tenth of a second."""
    found: dict[str, list[Variable]] = {}
    file = ELFFile(BytesIO(program))
    if file.has_dwarf_info():
        _Reader(found).read(file.get_dwarf_info())
    return found


class Variables(Mapping[str, Variable]):
    """All variables in RAM with a fixed address, by name.

    The processor's registers are included, by their names in the data sheet. Raises ElfError: the
    program does not have the name, or has it more than once.
    """

    def __init__(self, elf: Elf) -> None:
        self._elf = elf
        self._all = _described(elf.path.read_bytes())
        self._found: dict[str, Variable] = {}

    def __getitem__(self, name: str) -> Variable:
        if name not in self._found:
            self._found[name] = self._described(name)
        return self._found[name]

    def _described(self, name: str) -> Variable:
        file, _, path = name.rpartition(":")
        steps = _steps(path)
        found = self._find(file, steps[0][0])
        for member, index in steps[1:]:
            found = found.step(member) if member else found.element(int(index))
        return found

    def __contains__(self, name: object) -> bool:
        try:
            return isinstance(name, str) and bool(self[name])
        except ElfError:
            return False

    def of_file(self, file: str) -> list[Variable]:
        """List the variables that a source file defines, such as "control.c"; "" for registers."""
        start = f"{file}:"
        return [each for key in self._all if key.startswith(start) for each in self._all[key]]

    @property
    def files(self) -> tuple[str, ...]:
        """The source files in C that define variables."""
        return tuple(sorted({key.partition(":")[0] for key in self._all if ".c:" in key}))

    def _find(self, file: str, name: str) -> Variable:
        found = self._all.get(f"{file}:{name}" if file else name, [])
        if len(found) == 1:
            return found[0]
        if found:
            raise ElfError(f"{self._elf.path.name} has {name} in several files: name the file.")
        raise ElfError(f"{self._elf.path.name} has no variable {name}{self._hint()}.")

    def _hint(self) -> str:
        """Return a hint if only registers are described: the program has no debug information."""
        first = self._elf.static_ram[0]
        if any(variable.address >= first for found in self._all.values() for variable in found):
            return ""
        return ", nor any other: compile it with -gdwarf-2"

    def __iter__(self) -> Iterable[str]:  # type: ignore[override]
        return iter(name for name, found in self._all.items() if len(found) == 1)

    def __len__(self) -> int:
        return sum(len(found) == 1 for found in self._all.values())

    def decode(
        self, images: NDArray[np.uint8], base: int, names: Iterable[str]
    ) -> NDArray[np.void]:
        """View RAM images as variables, without copying.

        images -- one image per row, contiguous; base -- RAM address of the first column.
        Returns one record per image, a field per name. Raises ElfError: a variable lies outside the
        images.
        """
        found = {name: self[name] for name in names}
        width = images.shape[1]
        for name, variable in found.items():
            if variable.address < base or variable.address + variable.size > base + width:
                raise ElfError(f"{name} is not in the RAM range that was recorded.")
        dtype = np.dtype(
            {
                "names": list(found),
                "formats": [variable.dtype for variable in found.values()],
                "offsets": [variable.address - base for variable in found.values()],
                "itemsize": width,
            }
        )
        return np.ascontiguousarray(images).view(dtype)[:, 0]


def _steps(path: str) -> list[tuple[str, str]]:
    if not _PATH.fullmatch(path):
        raise ElfError(f"{path!r} is not the name of a variable.")
    return [(str(member), str(index)) for member, index in _STEP.findall(path)]


class _Reader:
    """Collects the variables from the debug information."""

    def __init__(self, into: dict[str, list[Variable]]) -> None:
        self._into = into
        self._seen: set[tuple[str, int]] = set()

    def read(self, info: Any) -> None:
        types = Types()
        for unit in info.iter_CUs():
            file = Path(_name(unit.get_top_DIE()) or "").name
            for die in unit.iter_DIEs():
                if die.tag == "DW_TAG_variable":
                    self._add(die, file, types)

    def _add(self, die: Any, file: str, types: Types) -> None:
        address = _address(die)
        name = _name(die)
        origin = _origin(die)
        if address is None or name is None or (name, address) in self._seen:
            return
        self._seen.add((name, address))
        dtype = types.dtype(die if "DW_AT_type" in die.attributes else origin)
        variable = Variable(name, address, dtype)
        self._into.setdefault(name, []).append(variable)
        self._into.setdefault(f"{file}:{name}", []).append(variable)


def _origin(die: Any) -> Any:
    for attribute in ("DW_AT_specification", "DW_AT_abstract_origin"):
        if attribute in die.attributes:
            return die.get_DIE_from_attribute(attribute)
    return die


def _name(die: Any) -> str | None:
    found = die.attributes.get("DW_AT_name") or _origin(die).attributes.get("DW_AT_name")
    return found.value.decode() if found else None


def _address(die: Any) -> int | None:
    """Return the RAM address of a variable that has a fixed one."""
    location = die.attributes.get("DW_AT_location")
    if location is None or not isinstance(location.value, list):
        return None
    if len(location.value) != 5 or location.value[0] != _OP_ADDR:
        return None
    address = int.from_bytes(bytes(location.value[1:]), "little")
    return address - RAM if RAM <= address < RAM + 0x10000 else None
