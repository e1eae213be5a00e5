"""The layout of the firmware's state from its own headers: names, widths, offsets."""

import re
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from cffi import FFI

from heatwright.sim.host.build import HERE
from heatwright.sim.host.parts import Parts, control_files, program_files

_COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.DOTALL)
_DIRECTIVE = re.compile(r"^[ \t]*#.*$", re.MULTILINE)

_NUMPY = {"float": "f4", "_Bool": "u1", "bool": "u1"}


@cache
def declarations(project: Path, *loops: Parts) -> Any:
    """Parse the headers of the files under test, with packed structures."""
    source = project / "src"
    names = ["fault", "settings", "gate", "reset"]
    for parts in loops:
        names += ["mode"] * parts.tunable
        names += [f"{kind}_{parts.name}" for kind in control_files(parts)]
        names += [f"output_{name}" for name in (parts.heater, parts.cooler) if name]
        names += [f"current_{parts.heater}"] * (parts.ammeter is not None)
        names += ["state"] * parts.switched
        names += program_files(parts)
        names += [f"response_{parts.name}"] * parts.response
        names += [f"monitor_{name}" for name, *_ in parts.watched]
    names += ["text"] * (source / "text.h").exists()
    ffi = FFI()
    for header in (*(source / f"{name}.h" for name in dict.fromkeys(names)), HERE / "world.h"):
        bare = _DIRECTIVE.sub("", _COMMENT.sub("", header.read_text(encoding="utf-8")))
        ffi.cdef(bare, packed=header.name != "text.h")
    return ffi


def state_type(ffi: Any, parts: Parts) -> np.dtype[Any]:
    """Return the type of the state that `host_state` writes, with the names of docs/control.md."""
    structures = {
        "": f"loop_{parts.name}_state",
        "guard.": f"guard_{parts.name}_state",
        "algorithm.": f"algorithm_{parts.name}_state",
        "fault.": "fault_state",
    }
    if parts.has_output_state:
        structures["output."] = f"output_{parts.heater}_state"
    if parts.autotune:
        structures["autotune."] = f"autotune_{parts.name}_state"
    if parts.ammeter:
        structures["current."] = f"current_{parts.heater}_state"
    if parts.programmed:
        structures["program."] = "program_state"
    if parts.response:
        structures["response."] = f"response_{parts.name}_state"
    structures |= {f"monitor_{name}.": f"monitor_{name}_state" for name, *_ in parts.watched}
    fields = [
        (f"{prefix}{name}", _width(field.type))
        for prefix, structure in structures.items()
        for name, field in ffi.typeof(f"struct {structure}").fields
    ]
    last = "state" if parts.switched else "ready"
    return np.dtype([*fields, *([(last, "u1")] if parts.commanded else [])])


def _width(kind: Any) -> str:
    if kind.cname in _NUMPY:
        return _NUMPY[kind.cname]
    match = re.fullmatch(r"(u?)int(8|16|32)_t", kind.cname)
    if match is None:
        raise ValueError(f"A state member cannot have the type {kind.cname}")
    return f"{match[1] or 'i'}{int(match[2]) // 8}"
