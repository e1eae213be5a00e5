"""DWARF types as numpy types, as the AVR lays them out: no padding, little-endian."""

from typing import Any

import numpy as np

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
