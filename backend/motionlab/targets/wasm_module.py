"""A WebAssembly object file, as LLVM writes it, made a module: no linker needed.

LLVM's objects hold final indices of functions and types, and functions on vectors alone have no
data and no stack. What an object lacks is a section of exports; its symbols and relocations serve
linkers only.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

_HEADER = b"\0asm\1\0\0\0"
_CUSTOM, _TYPE, _IMPORT, _FUNCTION, _EXPORT, _CODE = 0, 1, 2, 3, 7, 10
_FUNCTION_KIND, _MEMORY_KIND = 0, 2
_SYMBOLS = 8  # subsection of "linking"
_UNDEFINED, _EXPLICIT_NAME = 0x10, 0x40

MEMORY = ("env", "memory")
"""Module and name of the only import."""


def module_of(objects: bytes, exports: Iterable[str]) -> bytes:
    """Return an object file as a module.

    Parameters
    ----------
    objects : bytes
        WebAssembly object file.
    exports : iterable of str
        Functions to export.

    Raises
    ------
    ValueError
        If the object needs more than memory: a function, a global variable or data.
    """
    sections = list(_sections(objects))
    kinds = {kind for kind, _ in sections}
    foreign = kinds - {_CUSTOM, _TYPE, _IMPORT, _FUNCTION, _CODE}
    if foreign:
        raise ValueError(f"object has sections beside types, functions and code: {sorted(foreign)}")
    functions = {}
    for kind, content in sections:
        if kind == _IMPORT:
            _check_imports(content)
        elif kind == _CUSTOM:
            functions |= _functions(content)
    memory = _name(MEMORY[0]) + _name(MEMORY[1]) + bytes([_MEMORY_KIND, 0]) + _number(1)
    entries = [_name(n) + bytes([_FUNCTION_KIND]) + _number(functions[n]) for n in exports]
    parts = {kind: content for kind, content in sections if kind != _CUSTOM}
    parts |= {_IMPORT: _vector([memory]), _EXPORT: _vector(entries)}
    return _HEADER + b"".join(_section(kind, parts[kind]) for kind in sorted(parts))


def with_custom_section(module: bytes, name: str, content: bytes) -> bytes:
    """Return a module with a custom section at its end."""
    return module + _section(_CUSTOM, _name(name) + content)


def custom_section(module: bytes, name: str) -> bytes | None:
    """Return the content of a custom section; None if there is none of that name."""
    for kind, content in _sections(module):
        if kind == _CUSTOM:
            title, start = _text(content, 0)
            if title == name:
                return content[start:]
    return None


def _sections(data: bytes) -> Iterator[tuple[int, bytes]]:
    if not data.startswith(_HEADER):
        raise ValueError("not WebAssembly")
    at = len(_HEADER)
    while at < len(data):
        kind = data[at]
        size, at = _read_number(data, at + 1)
        yield kind, data[at : at + size]
        at += size


def _check_imports(content: bytes) -> None:
    count, at = _read_number(content, 0)
    for _ in range(count):
        _, at = _text(content, at)
        name, at = _text(content, at)
        if content[at] != _MEMORY_KIND:
            raise ValueError(f"object imports {name}, which is no memory")
        flags, at = _read_number(content, at + 1)
        for _ in range(1 + (flags & 1)):
            _, at = _read_number(content, at)


def _functions(content: bytes) -> dict[str, int]:
    """Return the index of each function that the symbols of a section "linking" define."""
    name, at = _text(content, 0)
    if name != "linking":
        return {}
    _, at = _read_number(content, at)  # version
    functions = {}
    while at < len(content):
        kind = content[at]
        size, at = _read_number(content, at + 1)
        if kind == _SYMBOLS:
            functions |= _function_symbols(content[at : at + size])
        at += size
    return functions


def _function_symbols(content: bytes) -> dict[str, int]:
    count, at = _read_number(content, 0)
    functions = {}
    for _ in range(count):
        kind = content[at]
        flags, at = _read_number(content, at + 1)
        if kind != _FUNCTION_KIND or flags & _UNDEFINED:
            raise ValueError("object has symbols beside its own functions")
        index, at = _read_number(content, at)
        name, at = _text(content, at)
        functions[name] = index
    return functions


def _section(kind: int, content: bytes) -> bytes:
    return bytes([kind]) + _number(len(content)) + content


def _vector(entries: list[bytes]) -> bytes:
    return _number(len(entries)) + b"".join(entries)


def _name(text: str) -> bytes:
    encoded = text.encode()
    return _number(len(encoded)) + encoded


def _number(value: int) -> bytes:
    """Return a number in LEB128."""
    digits = []
    while True:
        value, digit = value >> 7, value & 0x7F
        digits.append(digit | (0x80 if value else 0))
        if not value:
            return bytes(digits)


def _read_number(data: bytes, at: int) -> tuple[int, int]:
    """Return a number in LEB128 and the place after it."""
    value = shift = 0
    while True:
        value |= (data[at] & 0x7F) << shift
        at += 1
        if data[at - 1] < 0x80:
            return value, at
        shift += 7


def _text(data: bytes, at: int) -> tuple[str, int]:
    size, at = _read_number(data, at)
    return data[at : at + size].decode(), at + size
