"""REVIVE: an exact, portable checkpoint.

Only the name is DL_POLY's. Its REVIVE is a dump of Fortran variables whose layout depends on compiler and version; ours
is a NumPy ``.npz`` archive (a zip file of ``.npy`` arrays, readable with ``numpy.load``) that holds every array bit for
bit, a JSON text with everything else, a format number and a SHA-256 sum of it all. Nothing in it is ever executed.
"""

from __future__ import annotations

import hashlib
import json
import os
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pydlpoly.errors import InputError
from pydlpoly.formats.atomic import PathLike, atomic_file

FORMAT_NAME = "pydlpoly checkpoint"
FORMAT_VERSION = 1
DEFAULT_NAME = "REVIVE"
_HEADER = "__pydlpoly__"
_ENTRY_DATE = (1980, 1, 1, 0, 0, 0)  # equal states give equal files, whenever they are written
_SAFE_KINDS = "biufcSU"

AnyArray = NDArray[Any]


def write_checkpoint(path: PathLike, arrays: Mapping[str, AnyArray], meta: Mapping[str, Any]) -> None:
    """Write a checkpoint in one instant: a kill leaves the previous one untouched.

    Args:
        path: the file.
        arrays: numeric, boolean or fixed-length text arrays by name.
        meta: everything else, of JSON's types; floats keep every bit.

    Raises:
        RunError: the file cannot be written.
        ValueError: an array of Python objects, a reserved or empty name, or meta that JSON cannot hold.
    """
    plain = {name: np.asarray(array) for name, array in arrays.items()}
    for name, array in plain.items():
        if not name or name == _HEADER or "/" in name:
            raise ValueError(f"{name!r} cannot be the name of an array")
        if array.dtype.kind not in _SAFE_KINDS:
            raise ValueError(f"array {name!r} of type {array.dtype} cannot be stored exactly")
    try:
        text = json.dumps(dict(meta), allow_nan=False, sort_keys=True)
    except TypeError as error:
        raise ValueError(f"the meta data of a checkpoint must be JSON: {error}") from error
    header = {"format": FORMAT_NAME, "version": FORMAT_VERSION, "sha256": _checksum(plain, text), "meta": text}
    head = np.frombuffer(json.dumps(header).encode("utf-8"), dtype=np.uint8)
    with atomic_file(path) as handle, zipfile.ZipFile(handle, "w", zipfile.ZIP_STORED) as archive:
        for name, array in {_HEADER: head, **plain}.items():
            entry = zipfile.ZipInfo(f"{name}.npy", date_time=_ENTRY_DATE)
            with archive.open(entry, "w", force_zip64=True) as member:
                np.lib.format.write_array(member, array, allow_pickle=False)


def read_checkpoint(path: PathLike) -> tuple[dict[str, AnyArray], dict[str, Any]]:
    """Read a checkpoint and verify its sum.

    Returns:
        The arrays (in this machine's byte order) and the meta data.

    Raises:
        InputError: the file is missing, cut short, damaged, from a newer version, or something else altogether, such
            as a REVIVE or REVOLD of DL_POLY.
    """
    name = os.fspath(path)
    try:
        stored = _load(Path(path), name)
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}", path=name) from error
    if _HEADER not in stored:
        raise InputError("is an archive of arrays, but not a checkpoint of pydlpoly", path=name)
    header = _header(stored.pop(_HEADER), name)
    if header["sha256"] != _checksum(stored, header["meta"]):
        raise InputError("is damaged: its content does not have the SHA-256 sum it was written with", path=name)
    return stored, json.loads(header["meta"])


def _load(path: Path, name: str) -> dict[str, AnyArray]:
    stored: dict[str, AnyArray] = {}
    with path.open("rb") as handle:
        start = handle.read(4)
        if start != b"PK\x03\x04":
            raise InputError(_foreign(start), path=name)
        try:
            with zipfile.ZipFile(handle) as archive:
                for entry in archive.namelist():
                    with archive.open(entry) as member:
                        array = np.lib.format.read_array(member, allow_pickle=False)
                    stored[entry.removesuffix(".npy")] = array.astype(array.dtype.newbyteorder("="), copy=False)
        except (zipfile.BadZipFile, zlib.error, ValueError, EOFError, NotImplementedError, RuntimeError) as error:
            raise InputError(f"is a checkpoint that is cut short or damaged ({error})", path=name) from error
    return stored


def _foreign(start: bytes) -> str:
    if not start:
        return "is empty: the checkpoint was never written"
    return "is not a checkpoint of pydlpoly (DL_POLY's own REVIVE and REVOLD cannot be read; start from REVCON instead)"


def _header(content: AnyArray, name: str) -> dict[str, str]:
    try:
        header = json.loads(content.tobytes())
        kind, version = header["format"], header["version"]
    except (ValueError, KeyError, TypeError) as error:
        raise InputError("is a checkpoint whose header is damaged", path=name) from error
    if kind != FORMAT_NAME or not isinstance(version, int):
        raise InputError("is not a checkpoint of pydlpoly", path=name, word=str(kind))
    if version > FORMAT_VERSION:
        message = f"was written by a newer pydlpoly in format {version}; this one reads formats up to {FORMAT_VERSION}"
        raise InputError(message, path=name)
    if not all(isinstance(header.get(key), str) for key in ("sha256", "meta")):
        raise InputError("is a checkpoint whose header is damaged", path=name)
    return {"sha256": header["sha256"], "meta": header["meta"]}


def _checksum(arrays: Mapping[str, AnyArray], meta: str) -> str:
    """SHA-256 over names, types, shapes and little-endian bytes of all arrays, and the meta text."""
    total = hashlib.sha256(meta.encode("utf-8"))
    for name in sorted(arrays):
        array = arrays[name]
        little = array.astype(array.dtype.newbyteorder("<"), copy=False)
        total.update(f"\0{name}\0{little.dtype.str}\0{little.shape}\0".encode())
        total.update(np.ascontiguousarray(little).tobytes())
    return total.hexdigest()
