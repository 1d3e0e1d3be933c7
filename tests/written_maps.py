"""Reads maps that polishc wrote with libraries that we did not write, and compares them pixel by pixel.

    pip install prysm==0.21.1 surfalize==0.19.2 h5py numpy
    cargo build --example convert
    python tests/written_maps.py target/debug/examples/convert

Not a part of `cargo test`: it needs Python. It ends with status 1 at the first difference.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from prysm import io
from surfalize import Surface

CONVERT = sys.argv[1]
ROWS, COLUMNS = 37, 53
STEP_X, STEP_Y = 0.25, 0.4  # mm


def heights():
    """A map in nm, row 0 on top, that no turn or mirror leaves as it is, with pixels that were not measured."""
    row, column = np.mgrid[:ROWS, :COLUMNS]
    values = 80 * np.sin(0.2 * column) * np.cos(0.13 * row) + 0.7 * column - 0.3 * row
    values[3, 5] = 345.678
    values[(row - 18) ** 2 / 300 + (column - 26) ** 2 / 700 > 1] = np.nan
    values[20:23, 30:34] = np.nan
    return values


def convert(*words):
    subprocess.run([CONVERT, *map(str, words)], check=True)


def same(what, found, expected, within):
    """Equal pixel by pixel to `within` nm, and unknown at the same pixels."""
    assert found.shape == expected.shape, (what, found.shape, expected.shape)
    assert np.array_equal(np.isnan(found), np.isnan(expected)), what
    worst = np.nanmax(np.abs(found - expected))
    print(f"{what}: {found.shape[1]} x {found.shape[0]}, {np.isfinite(found).sum()} valid, worst difference {worst:.3g} nm")
    assert worst <= within, (what, worst, within)


def near(what, found, expected, relative=1e-6):
    print(f"{what}: {found!r}")
    assert abs(found / expected - 1) <= relative, (what, found, expected)


with tempfile.TemporaryDirectory() as folder:
    folder = Path(folder)
    expected = heights()
    np.save(folder / "map.npy", expected)

    # MetroPro by prysm: heights in nm, metres a pixel. Half a count is 632.8 nm * 0.5 / 32768 / 2.
    convert("--unit", "1nm", "--pixel", f"{STEP_X}mm", folder / "map.npy", folder / "map.dat")
    found = io.read_zygo_dat(folder / "map.dat")
    same("MetroPro, by prysm", found["phase"], expected, 632.8 * 0.5 / 32768 / 2 * 1.01)
    near("MetroPro, by prysm: metres a pixel", found["meta"]["lateral_resolution"], STEP_X * 1e-3)

    # X3P by surfalize: micrometres, steps in micrometres.
    convert("--unit", "1nm", "--pixel", f"{STEP_X}mm", folder / "map.npy", folder / "map.x3p")
    found = Surface.load(folder / "map.x3p")
    same("X3P, by surfalize", found.data * 1e3, expected, 1e-9)
    near("X3P, by surfalize: step in x", found.step_x, STEP_X * 1e3)
    near("X3P, by surfalize: step in y", found.step_y, STEP_X * 1e3)

    # Oblong pixels, from a table of points with y upwards.
    with open(folder / "map.csv", "w") as table:
        table.write("x (mm), y (mm), z (nm)\n")
        for row in range(ROWS):
            for column in range(COLUMNS):
                y = (ROWS - 1 - row) * STEP_Y
                table.write(f"{column * STEP_X:.4f},{y:.4f},{float(expected[row, column])!r}\n")
    convert(folder / "map.csv", folder / "oblong.x3p")
    found = Surface.load(folder / "oblong.x3p")
    same("X3P with oblong pixels, by surfalize", found.data * 1e3, expected, 1e-9)
    near("X3P with oblong pixels: step in x", found.step_x, STEP_X * 1e3)
    near("X3P with oblong pixels: step in y", found.step_y, STEP_Y * 1e3)

    # CODE V by prysm: heights in nm. prysm 0.21.1 leaves the rows in the order of the file, from the lowest upwards, and
    # takes the two sides of the grid for each other; its numbers are right for the wavelength of 1 um that is written.
    convert("--unit", "1nm", folder / "map.npy", folder / "map.int")
    found, meta = io.read_codev_gridint(folder / "map.int")
    found = found.reshape(ROWS, COLUMNS)[::-1]
    same("CODE V, by prysm", found, expected, np.nanmax(np.abs(expected)) / 65532 * 1.01)
    assert meta["data meaning"] == "surface error", meta

    # Zygo's ASCII, which prysm writes, is read by us. prysm 0.21.1 divides by the wavelength in micrometres once too often and
    # takes millimetres a pixel for a thousandth of them, so both are given to it changed; and it cuts its counts off.
    io.write_zygo_ascii(str(folder / "map.asc"), expected * 0.6328e-3, STEP_X * 1e-6, wavelength=0.6328)
    convert(folder / "map.asc", folder / "map.x3p")
    found = Surface.load(folder / "map.x3p")
    same("Zygo ASCII, written by prysm", found.data * 1e3, expected, 632.8 * 0.5 / 32768 * 1.01)
    near("Zygo ASCII, written by prysm: step", found.step_x, STEP_X * 1e3)

# Files of real instruments, read by us and by them; POLISHC_SAMPLES names the folder.
samples = Path(os.environ.get("POLISHC_SAMPLES", "../shared/samples"))
with tempfile.TemporaryDirectory() as folder:
    for name, theirs in [
        ("zygo_metropro.dat", lambda path: io.read_zygo_dat(path)["phase"]),
        ("zygo_mx.datx", lambda path: io.read_zygo_datx(path)["phase"]),
        ("areal.x3p", lambda path: Surface.load(path).data * 1e3),
        ("ascii.sdf", lambda path: Surface.load(path).data * 1e3),
    ]:
        if not (samples / name).exists():
            print(f"SKIPPED: there is no sample {samples / name}")
            continue
        convert(samples / name, Path(folder) / "map.x3p")
        ours = Surface.load(Path(folder) / "map.x3p").data * 1e3
        same(f"{name}, read by us and by prysm or surfalize", ours, np.asarray(theirs(samples / name)), 1e-9)

print("all maps agree")
