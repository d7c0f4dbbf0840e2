"""Reads particles.vtkhdf through the HDF5 library that the program itself is linked to: no h5py is needed where the program runs.

Layout (VTKHDF 2.x, PolyData): /VTKHDF/Points and PointData/NAME hold the rows of all steps one after the other;
Steps/Values are the times, Steps/PointOffsets the first row of each, NumberOfPoints[Steps/PartOffsets] their number.
"""
import ctypes
import re
import subprocess

import numpy

HID = ctypes.c_int64


def library(program):
    listed = subprocess.run(["ldd", program], capture_output=True, text=True, check=False).stdout
    found = re.search(r"=> (\S*libhdf5\S*\.so\S*)", listed)
    h5 = ctypes.CDLL(found[1] if found else "libhdf5.so")
    for name in ("H5Fopen", "H5Dopen2", "H5Dget_space", "H5Screate_simple"):
        getattr(h5, name).restype = HID
    h5.H5open()
    return h5


class Particles:
    def __init__(self, path, program):
        self.h5 = library(program)
        self.file = self.h5.H5Fopen(str(path).encode(), 0, HID(0))
        if self.file < 0:
            raise OSError(f"{path} cannot be opened as HDF5")
        self.times = self.read("Steps/Values")
        self.starts = self.read("Steps/PointOffsets").astype(int)
        parts = self.read("Steps/PartOffsets").astype(int)
        self.ends = self.starts + self.read("NumberOfPoints").astype(int)[parts]  # steps begin at whole chunks: rows between are not particles

    def open(self, name):
        data = self.h5.H5Dopen2(HID(self.file), f"/VTKHDF/{name}".encode(), HID(0))
        if data < 0:
            raise OSError(f"no {name} in the series (output.fields of the scene leaves it out?)")
        space = self.h5.H5Dget_space(HID(data))
        extent = (ctypes.c_uint64 * 4)()
        rank = self.h5.H5Sget_simple_extent_dims(HID(space), extent, None)
        return data, space, list(extent[:rank])

    def close(self, data, space):
        self.h5.H5Sclose(HID(space))
        self.h5.H5Dclose(HID(data))

    def read(self, name, start=0, end=None):
        """Rows of a data set, as doubles."""
        data, space, extent = self.open(name)
        extent[0] = (extent[0] if end is None else end) - start
        counts = (ctypes.c_uint64 * len(extent))(*extent)
        first = (ctypes.c_uint64 * len(extent))(start)
        self.h5.H5Sselect_hyperslab(HID(space), 0, first, None, counts, None)
        memory = self.h5.H5Screate_simple(len(extent), counts, None)
        values = numpy.empty(extent)
        double = HID.in_dll(self.h5, "H5T_NATIVE_DOUBLE_g")
        if self.h5.H5Dread(HID(data), double, HID(memory), HID(space), HID(0), values.ctypes.data_as(ctypes.c_void_p)) < 0:
            raise OSError(f"{name} of the series cannot be read")
        self.h5.H5Sclose(HID(memory))
        self.close(data, space)
        return values

    def at(self, time, name="Points"):
        """Rows of the output nearest to `time`; the last for None."""
        k = len(self.times) - 1 if time is None else int(numpy.abs(self.times - time).argmin())
        return self.read(name if name == "Points" else f"PointData/{name}", self.starts[k], self.ends[k])
