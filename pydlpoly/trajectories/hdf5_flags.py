"""Takes back the mark of an open file that a killed program leaves in an HDF5 file, as the tool ``h5clear -s`` does.

A file that is written in SWMR mode (single writer, multiple readers) is whole at any time, but says in its superblock
that a writer has it open. After a kill it still does, and HDF5 refuses it. The superblock's layout (versions 2 and 3)
and its checksum, Bob Jenkins' lookup3, are those of the HDF5 File Format Specification.
"""

from __future__ import annotations

import os
import struct
from pathlib import Path

_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_FLAGS, _CHECKED = 11, 44  # place of the flags; bytes that the checksum covers, with 8-byte addresses
_WORD = 0xFFFFFFFF


def clear_open_flags(path: str | os.PathLike[str]) -> bool:
    """Mark an HDF5 file as closed; return whether it was not."""
    with Path(path).open("r+b") as handle:
        block = bytearray(handle.read(_CHECKED))
        known = block[:8] == _SIGNATURE and len(block) == _CHECKED and block[8] in (2, 3) and block[9] == 8
        if not known or not block[_FLAGS]:
            return False
        block[_FLAGS] = 0
        handle.seek(0)
        handle.write(bytes(block) + struct.pack("<I", lookup3(bytes(block))))
        handle.flush()
        os.fsync(handle.fileno())
    return True


def lookup3(data: bytes) -> int:
    """Return Jenkins' lookup3 hash (``hashlittle`` with initial value 0) of at least one byte."""
    a = b = c = (0xDEADBEEF + len(data)) & _WORD
    padded = data + bytes(-len(data) % 12)
    blocks = list(struct.iter_unpack("<3I", padded))
    for x, y, z in blocks[:-1]:
        a, b, c = _mixed((a + x) & _WORD, (b + y) & _WORD, (c + z) & _WORD)
    x, y, z = blocks[-1]
    return _final((a + x) & _WORD, (b + y) & _WORD, (c + z) & _WORD)


def _turned(x: int, bits: int) -> int:
    return (x << bits | x >> 32 - bits) & _WORD


def _mixed(a: int, b: int, c: int) -> tuple[int, int, int]:
    for bits in (4, 6, 8, 16, 19, 4):  # the three words change places after each
        a = (a - c & _WORD) ^ _turned(c, bits)
        c = c + b & _WORD
        a, b, c = b, c, a
    return a, b, c


def _final(a: int, b: int, c: int) -> int:
    for bits in (14, 11, 25, 16, 4, 14, 24):
        c = (c ^ b) - _turned(b, bits) & _WORD
        a, b, c = b, c, a
    return b
