"""The checkpoint: bit for bit, and a clear refusal of everything else."""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays, scalar_dtypes

from pydlpoly.errors import InputError, RunError
from pydlpoly.formats.checkpoint import FORMAT_VERSION, read_checkpoint, write_checkpoint

ARRAYS: dict[str, np.ndarray[Any, Any]] = {
    "positions": np.random.default_rng(3).normal(size=(50, 3)),
    "odd": np.array([0.0, -0.0, 5e-324, np.nan, np.inf, 1.0 + 2**-52]),
    "species": np.arange(7, dtype=np.int32),
    "frozen": np.array([True, False]),
    "empty": np.zeros((0, 3)),
    "names": np.array(["W", "HEADBEAD"]),
    "file": np.array(3, dtype=np.int64),
}
META = {"step": 2**60, "time": 0.1 + 0.2, "title": "Å soft", "seed": None, "counts": [1, 2.5]}


def test_everything_comes_back_bit_for_bit(tmp_path: Path) -> None:
    write_checkpoint(tmp_path / "REVIVE", ARRAYS, META)
    stored, meta = read_checkpoint(tmp_path / "REVIVE")
    assert meta == META
    assert list(stored) == list(ARRAYS)
    for name, array in ARRAYS.items():
        assert (stored[name].dtype, stored[name].shape) == (array.dtype, array.shape)
        assert stored[name].tobytes() == array.tobytes()


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=50, deadline=None)
@given(
    array=arrays(scalar_dtypes().filter(lambda d: d.kind in "biufc"), array_shapes(min_side=0)),
    number=st.floats(allow_nan=False, allow_infinity=False),
)
def test_any_array_and_number_come_back(tmp_path: Path, array: np.ndarray[Any, Any], number: float) -> None:
    write_checkpoint(tmp_path / "REVIVE", {"a": array}, {"x": number})
    stored, meta = read_checkpoint(tmp_path / "REVIVE")
    assert stored["a"].tobytes() == array.astype(array.dtype.newbyteorder("=")).tobytes()
    assert repr(meta["x"]) == repr(number)


def test_equal_states_give_equal_files_that_numpy_opens_too(tmp_path: Path) -> None:
    write_checkpoint(tmp_path / "A", ARRAYS, META)
    write_checkpoint(tmp_path / "B", ARRAYS, META)
    assert (tmp_path / "A").read_bytes() == (tmp_path / "B").read_bytes()
    with np.load(tmp_path / "A", allow_pickle=False) as archive:
        np.testing.assert_array_equal(archive["positions"], ARRAYS["positions"])


def test_arrays_of_the_other_byte_order_become_native(tmp_path: Path) -> None:
    swapped = np.array([1.5, -2.25]).astype(np.dtype("f8").newbyteorder("S"))
    write_checkpoint(tmp_path / "REVIVE", {"x": swapped}, {})
    stored, _ = read_checkpoint(tmp_path / "REVIVE")
    assert stored["x"].dtype.isnative
    np.testing.assert_array_equal(stored["x"], [1.5, -2.25])


def test_a_checkpoint_cut_anywhere_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "REVIVE"
    write_checkpoint(path, ARRAYS, META)
    whole = path.read_bytes()
    for length in [0, 1, 4, 100, len(whole) // 2, len(whole) - 30, len(whole) - 1]:
        path.write_bytes(whole[:length])
        with pytest.raises(InputError, match=r"REVIVE: is (empty|not a checkpoint|a checkpoint that is cut short)"):
            read_checkpoint(path)


def test_no_damaged_byte_changes_the_state(tmp_path: Path) -> None:
    path = tmp_path / "REVIVE"
    write_checkpoint(path, {"positions": ARRAYS["positions"]}, META)
    whole = path.read_bytes()
    expected = ARRAYS["positions"].tobytes()
    for place in range(0, len(whole), 17):
        damaged = bytearray(whole)
        damaged[place] ^= 0x40
        path.write_bytes(damaged)
        try:  # a byte of the archive's own bookkeeping may be harmless; then everything must be as it was
            stored, meta = read_checkpoint(path)
        except InputError:
            continue
        assert meta == META
        assert {name: array.tobytes() for name, array in stored.items()} == {"positions": expected}


def rewritten(path: Path, change: dict[str, object], replace: dict[str, np.ndarray[Any, Any]] | None = None) -> None:
    """Write the archive anew with correct zip sums but another header or other arrays."""
    with np.load(path, allow_pickle=False) as archive:
        content = {name: archive[name] for name in archive.files}
    header = {**json.loads(content["__pydlpoly__"].tobytes()), **change}
    content["__pydlpoly__"] = np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)
    buffer = io.BytesIO()
    np.savez(buffer, **{**content, **(replace or {})})  # type: ignore[arg-type]
    path.write_bytes(buffer.getvalue())


@pytest.mark.parametrize(
    ("change", "replace", "message"),
    [
        ({"version": FORMAT_VERSION + 1}, None, "by a newer pydlpoly in format 2; this one reads formats up to 1"),
        ({"format": "other"}, None, "'other': is not a checkpoint of pydlpoly"),
        ({"sha256": None}, None, "header is damaged"),
        ({"meta": "{}"}, None, "does not have the SHA-256 sum"),
        ({}, {"x": np.array([1.0, 2.0, 4.0])}, "does not have the SHA-256 sum"),
        ({}, {"x": np.array([[1.0, 2.0, 3.0]])}, "does not have the SHA-256 sum"),
    ],
)
def test_what_is_not_ours_or_was_changed_is_refused(
    tmp_path: Path, change: dict[str, object], replace: dict[str, np.ndarray[Any, Any]] | None, message: str
) -> None:
    path = tmp_path / "REVIVE"
    write_checkpoint(path, {"x": np.array([1.0, 2.0, 3.0])}, META)
    rewritten(path, {})
    assert read_checkpoint(path)[1] == META  # the rewriting itself is harmless
    rewritten(path, change, replace)
    with pytest.raises(InputError, match=message):
        read_checkpoint(path)


def test_foreign_files_are_refused_by_what_they_are(tmp_path: Path) -> None:
    path = tmp_path / "REVIVE"
    path.write_bytes(np.arange(40.0).tobytes())
    with pytest.raises(InputError, match="DL_POLY's own REVIVE and REVOLD cannot be read"):
        read_checkpoint(path)
    np.savez(tmp_path / "other.npz", x=np.zeros(3))
    with pytest.raises(InputError, match="an archive of arrays, but not a checkpoint of pydlpoly"):
        read_checkpoint(tmp_path / "other.npz")
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("letter.txt", "hello")
    with pytest.raises(InputError, match="cut short or damaged"):
        read_checkpoint(path)
    with pytest.raises(InputError, match="cannot be read: No such file"):
        read_checkpoint(tmp_path / "REVOLD")


def test_pickled_objects_are_neither_written_nor_read(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="'x' of type object cannot be stored"):
        write_checkpoint(tmp_path / "REVIVE", {"x": np.array([None])}, {})
    np.savez(tmp_path / "pickle.npz", x=np.array([{}]), allow_pickle=True)
    with pytest.raises(InputError, match="cut short or damaged"):
        read_checkpoint(tmp_path / "pickle.npz")


@pytest.mark.parametrize("meta", [{"x": np.float64}, {"x": float("nan")}, {"x": np.int64(1)}])
def test_meta_that_json_cannot_hold_is_refused_and_leaves_the_old_file(tmp_path: Path, meta: dict[str, object]) -> None:
    write_checkpoint(tmp_path / "REVIVE", ARRAYS, META)
    with pytest.raises(ValueError, match="JSON"):
        write_checkpoint(tmp_path / "REVIVE", ARRAYS, meta)
    assert read_checkpoint(tmp_path / "REVIVE")[1] == META


@pytest.mark.parametrize("name", ["", "__pydlpoly__", "a/b"])
def test_reserved_names_are_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(ValueError, match="cannot be the name of an array"):
        write_checkpoint(tmp_path / "REVIVE", {name: np.zeros(1)}, {})


def test_a_folder_that_is_missing_is_a_run_error(tmp_path: Path) -> None:
    with pytest.raises(RunError, match="cannot be written"):
        write_checkpoint(tmp_path / "nowhere" / "REVIVE", ARRAYS, META)
