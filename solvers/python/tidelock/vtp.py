"""Reads the snapshots of a run: VTK PolyData files with appended, compressed arrays.

Only what Tidelock writes; PyVista and ParaView read everything.
"""

from __future__ import annotations

import pathlib
import xml.etree.ElementTree as xml
import zlib
from dataclasses import dataclass, field

import numpy as np

TYPES = {"Float64": "<f8", "Float32": "<f4", "UInt32": "<u4", "UInt64": "<u8", "Int64": "<i8", "UInt8": "u1"}


@dataclass
class PolyData:
    """Arrays of particles by name, `Points` among them; `units` and names of `components` where the file states them."""

    time: float
    arrays: dict[str, np.ndarray]
    units: dict[str, str] = field(default_factory=dict)
    components: dict[str, list[str]] = field(default_factory=dict)
    groups: list[str] = field(default_factory=list)


def read(path: pathlib.Path) -> PolyData:
    """The particles of a file.

    Raises:
        ValueError: the file is none that Tidelock writes.
    """
    whole = path.read_bytes()
    head, mark, rest = whole.partition(b'<AppendedData encoding="raw">')
    if not mark:
        raise ValueError(f"{path}: no appended data; read it with pyvista.read")
    data = rest[rest.index(b"_") + 1 :]
    root = xml.fromstring(head + b"</VTKFile>")
    result = PolyData(np.nan, {})
    for element in root.iterfind(".//FieldData/*"):
        if element.get("Name") == "TimeValue":
            result.time = float(_array(element, data)[0])
        elif element.get("Name") == "group_names":
            codes = bytes(int(code) for code in (element.text or "").split())
            result.groups = [name.decode() for name in codes.split(b"\0") if name]
    for element in [*root.iterfind(".//PointData/DataArray"), *root.iterfind(".//Points/DataArray")]:
        name = element.get("Name", "")
        result.arrays[name] = _array(element, data)
        unit = element.findtext("InformationKey[@name='UNITS_LABEL']")
        if unit:
            result.units[name] = unit
        named = [element.get(f"ComponentName{k}") for k in range(int(element.get("NumberOfComponents", "1")))]
        if all(named):
            result.components[name] = [str(component) for component in named]
    return result


def _array(element: xml.Element, data: bytes) -> np.ndarray:
    """Blocks: their number, size of each, size of the last, compressed sizes, all as 64-bit words; then the blocks."""
    at = int(element.get("offset", "0"))
    count = int(np.frombuffer(data, "<u8", 1, at)[0])
    sizes = np.frombuffer(data, "<u8", count, at + 24)
    at += 24 + 8 * count
    parts = []
    for size in sizes.tolist():
        parts.append(zlib.decompress(data[at : at + size]))
        at += size
    values = np.frombuffer(b"".join(parts), TYPES[element.get("type", "")])
    components = int(element.get("NumberOfComponents", "1"))
    return values.reshape(-1, components) if components > 1 else values
