"""particles.vtkhdf: the particles at each output time, read one output at a time."""
import dataclasses
import pathlib
from typing import Any, Dict, Iterator, List, Optional, Sequence, Union

import numpy
from numpy.typing import NDArray

from .errors import Error


@dataclasses.dataclass
class Particles:
    """N particles at one output time, in the file's order (by block, not by id).

    time [s]; dimensions 2 or 3; position (N, dimensions) [m]; fields by name, (N,) or (N, components), vectors with
    as many components as the scene has dimensions, stress (N, 4) in 2-D (xx, yy, zz, xy) and (N, 6) in 3-D (xx, yy, zz,
    xy, yz, xz); units by name of the field, "" where there is none.
    """

    time: float
    dimensions: int
    position: NDArray[Any]
    fields: Dict[str, NDArray[Any]]
    units: Dict[str, str]

    def __len__(self) -> int:
        return len(self.position)

    def __getitem__(self, name: str) -> NDArray[Any]:
        """A field by its name. Raises Error if the run did not write it."""
        if name not in self.fields:
            raise Error(f"there is no field {name!r} (the run wrote {', '.join(self.fields)}). "
                        "Add it to output.fields of the scene?")
        return self.fields[name]

    def speed(self) -> NDArray[Any]:
        """|v| of each particle, (N,) [m/s].

        >>> two = Particles(0.0, 2, numpy.zeros((2, 2)), {"velocity": numpy.array([[3.0, 4.0], [0.0, 1.0]])}, {})
        >>> two.speed()
        array([5., 1.])
        """
        found: NDArray[Any] = numpy.sqrt((self["velocity"] ** 2).sum(axis=1))
        return found


class ParticleSeries:
    """The outputs of a run: `times` (outputs,) [s], then `series[k]`, or `series.at(time)`.

    Rows that pad the last chunk of each output belong to nobody and are never given out. Use as a context, or
    close() it. A run that still goes on may be read: open again for its later outputs.
    """

    def __init__(self, path: Union[str, pathlib.Path], dimensions: int = 3) -> None:
        self.path, self.dimensions = pathlib.Path(path), dimensions
        if not self.path.is_file():
            raise Error(f"{self.path} cannot be read (no such file). Did the run have --no-particles?")
        try:
            import h5py
        except ImportError as missing:
            raise Error(f"particles cannot be read ({missing}). pip install h5py?") from None
        try:
            # No lock: the writer of a run that goes on never changes what an opened file points to.
            self._file = h5py.File(self.path, "r", locking=False)
            top = self._file["VTKHDF"]
            steps = top["Steps"]
            self.times: NDArray[Any] = steps["Values"][:]
            self._first = steps["PointOffsets"][:]
            self._rows = top["NumberOfPoints"][:][steps["PartOffsets"][:]]
            self._points, self._data = top["Points"], top["PointData"]
        except (OSError, KeyError) as wrong:
            raise Error(f"{self.path} is no series of particles ({wrong}). Was it written by moraine run?") from None

    def __enter__(self) -> "ParticleSeries":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        self._file.close()

    def __len__(self) -> int:
        return len(self.times)

    def __iter__(self) -> Iterator[Particles]:
        return (self[k] for k in range(len(self)))

    def __getitem__(self, k: int) -> Particles:
        """Output k with all its fields; negative k counts from the end."""
        return self.read(k)

    @property
    def fields(self) -> List[str]:
        """Names of the fields in the file."""
        return list(self._data)

    def read(self, k: int, fields: Optional[Sequence[str]] = None) -> Particles:
        """Output k with the named fields (default: all). Raises IndexError, or Error for a field that is not there."""
        k = range(len(self))[k]
        rows = slice(int(self._first[k]), int(self._first[k] + self._rows[k]))
        arrays: Dict[str, NDArray[Any]] = {}
        units: Dict[str, str] = {}
        for name in self.fields if fields is None else fields:
            if name not in self._data:
                raise Error(f"{self.path} has no field {name!r} (it has {', '.join(self.fields)}). "
                            "Add it to output.fields of the scene?")
            values = self._data[name][rows]
            arrays[name] = values[:, : self.dimensions] if values.ndim == 2 and values.shape[1] == 3 else values
            unit = self._data[name].attrs.get("unit", b"-")
            unit = unit.decode() if isinstance(unit, bytes) else str(unit)
            units[name] = "" if unit == "-" else unit
        return Particles(float(self.times[k]), self.dimensions, self._points[rows][:, : self.dimensions], arrays, units)

    def nearest(self, time: float) -> int:
        """Number of the output whose time is nearest to `time` [s]."""
        return int(numpy.argmin(abs(self.times - time)))

    def at(self, time: float, fields: Optional[Sequence[str]] = None) -> Particles:
        """The output nearest to `time` [s]."""
        return self.read(self.nearest(time), fields)
