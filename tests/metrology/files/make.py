"""Makes the HDF5 files of this folder with h5py (pip install h5py numpy), as Zygo Mx and 4Sight lay them out.

    python tests/metrology/files/make.py

Heights: row r, column c has the value 10 * r + c, but the last pixel was not measured. What the tests expect of them is
worked out by hand in tests/metrology/formats.rs.
"""

from pathlib import Path

import h5py
import numpy as np

HERE = Path(__file__).parent
NO_DATA = np.finfo(np.float64).max
ROWS, COLUMNS = 3, 4
TEXT = h5py.string_dtype("utf-8")


def heights(no_data, kind):
    values = (10.0 * np.arange(ROWS)[:, None] + np.arange(COLUMNS)).astype(kind)
    values[-1, -1] = no_data
    return values


def converter(category, unit, parameters):
    kind = np.dtype([("Category", TEXT), ("BaseUnit", TEXT), ("Parameters", h5py.vlen_dtype(np.float64))])
    value = np.empty(1, kind)
    value[0] = (category, unit, np.array(parameters))
    return value


def datx(name, unit, pitch, sign, count=1):
    with h5py.File(HERE / name, "w", libver=("earliest", "v108")) as file:
        group = file.create_group("Data/Surface")
        for number in range(count):
            surface = group.create_dataset(f"{{Surface-{number}}}", data=heights(NO_DATA, "<f8"))
            for key, value in [
                ("Wavelength", 600e-9), ("Interferometric Scale Factor", 0.5), ("Obliquity Factor", 1.25),
                ("No Data", NO_DATA),
            ]:
                surface.attrs[key] = np.array([value])
            surface.attrs.create("Unit", [unit], dtype=TEXT)
            for axis, side in zip("XY", pitch):
                surface.attrs[f"{axis} Converter"] = converter("LateralCat", "Pixels", [0.0, side, 0.0, 0.0])
            surface.attrs["Z Converter"] = converter("HeightCat", unit, [0.0, 600e-9, 0.5, 1.25])
        attributes = file.create_group("Attributes/{0}")
        attributes.attrs["Data Context.Data Attributes.attr.sign"] = np.array([sign], dtype="<i2")


def four_sight(name, wavelength, **how):
    with h5py.File(HERE / name, "w", libver=("earliest", "v108")) as file:
        group = file.create_group("measurement0/genraw")
        group.create_dataset("data", data=heights(np.finfo(np.float32).max, "<f4"), **how)
        if wavelength:
            group.attrs["wavelength"] = np.bytes_(wavelength)


def elsewhere(name, link):
    """A file whose surfaces are said to be in another place."""
    with h5py.File(HERE / name, "w", libver=("earliest", "v108")) as file:
        file.create_group("Data")
        file["Data/Surface"] = link


def raw_elsewhere(name):
    """A surface whose numbers are said to stand in another file of the machine."""
    datx(name, "Fringes", (1e-3, 1e-3), 0)
    with h5py.File(HERE / name, "a", libver=("earliest", "v108")) as file:
        group = file["Data/Surface"]
        old = group["{Surface-0}"]
        new = group.create_dataset("new", (ROWS, COLUMNS), "<f8", external=[("make.py", 0, 8 * ROWS * COLUMNS)])
        for key in old.attrs:
            new.attrs.create(key, old.attrs[key], dtype=old.attrs.get_id(key).dtype)
        del group["{Surface-0}"]


def never_written(name):
    """A surface whose numbers were never written, as when Mx was stopped: HDF5 says zeros for them."""
    datx(name, "Fringes", (1e-3, 1e-3), 0)
    with h5py.File(HERE / name, "a", libver=("earliest", "v108")) as file:
        group = file["Data/Surface"]
        old = group["{Surface-0}"]
        new = group.create_dataset("new", (ROWS, COLUMNS), "<f8")
        for key in old.attrs:
            new.attrs.create(key, old.attrs[key], dtype=old.attrs.get_id(key).dtype)
        del group["{Surface-0}"]


datx("fringes.datx", "Fringes", (1e-3, 2e-3), 0)
datx("nanometres.datx", "NanoMeters", (0.0, 0.0), 1)
datx("furlongs.datx", "Furlongs", (1e-3, 1e-3), 0)
datx("two_surfaces.datx", "Fringes", (1e-3, 1e-3), 0, count=2)
four_sight("plain.h5", "500.0 nm")
four_sight("packed.h5", "0.5 um", chunks=(2, 3), compression="gzip", shuffle=True)
four_sight("no_unit.h5", "500.0")
four_sight("no_wavelength.h5", None)
elsewhere("in_another_file.datx", h5py.ExternalLink("fringes.datx", "/Data/Surface"))
elsewhere("in_itself.datx", h5py.SoftLink("/Data/Surface"))
never_written("never_written.datx")
raw_elsewhere("raw_in_another_file.datx")
