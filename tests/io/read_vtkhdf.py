"""Reads a particle series with VTK's own reader and checks every value against write_vtkhdf.cpp.

    read_vtkhdf.py series WRITER FOLDER MPIEXEC...    on 1 and 3 ranks, started, continued and cut
    read_vtkhdf.py kill COUNT WRITER FOLDER           the writer killed COUNT times in mid-write

WRITER is the program write_vtkhdf; FOLDER is emptied. Exit code 77: this Python has no vtk module,
nothing was tested.
"""
import os
import random
import shutil
import signal
import subprocess
import sys
import time

try:
    import numpy as np
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
except ImportError as missing:
    print(f"SKIPPED: {missing}. `pip install vtk numpy`, and -DMORAINE_PYTHON=<that python>?")
    sys.exit(77)

PARTICLES = 5000


def mix(x):
    x = x + np.uint64(0x9E3779B97F4A7C15)
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))


def number(ids, what):
    return (mix(ids * np.uint64(16) + np.uint64(what)) >> np.uint64(11)) * 2.0**-53


def blocks():
    key, table = 5, []
    per_block = (PARTICLES + 39) // 40
    for b in range(40):
        key += 1 + int(mix(np.uint64(b))) % 1000
        table.append([key, 0 if b % 7 == 3 else int(mix(np.uint64(key))) % (2 * per_block + 1)])
    return table


def reader_of(path):
    reader = vtk.vtkHDFReader()
    reader.SetFileName(path)
    reader.UpdateInformation()
    return reader


def times_of(reader):
    if reader.GetNumberOfSteps() == 1:  # VTK tells no times of a single step
        return [0.0]
    key = vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS()
    return list(reader.GetOutputInformation(0).Get(key) or [])


def check(reader, k, ranks):
    reader.UpdateTimeStep(0.1 * k)
    data = vtk.vtkPolyData.SafeDownCast(reader.GetOutputAsDataSet())
    table = blocks()
    table[5][1] -= min(table[5][1], 13 * k)
    rows = sum(count for _, count in table)
    assert data.GetNumberOfPoints() == rows, (k, data.GetNumberOfPoints(), rows)
    assert data.GetNumberOfVerts() == rows and data.GetNumberOfCells() == rows
    cells = data.GetVerts()
    assert (vtk_to_numpy(cells.GetConnectivityArray()) == np.arange(rows)).all(), "a vertex per point"
    assert (vtk_to_numpy(cells.GetOffsetsArray()) == np.arange(rows + 1)).all()

    ids = np.arange(rows, dtype=np.uint64)
    points = vtk_to_numpy(data.GetPoints().GetData())
    assert (points[:, 0] == number(ids, 0)).all() and (points[:, 1] == number(ids, 1)).all()
    assert (points[:, 2] == 0).all()
    assert data.GetBounds()[:2] == (points[:, 0].min(), points[:, 0].max())
    array = {data.GetPointData().GetArrayName(a): vtk_to_numpy(data.GetPointData().GetArray(a))
             for a in range(data.GetPointData().GetNumberOfArrays())}
    assert (array["id"] == ids).all()
    assert (array["velocity"] == np.stack([np.full(rows, k), number(ids, 1), np.zeros(rows)], 1)).all()
    for c in range(6):
        assert (array["stress"][:, c] == number(ids, 2 + c).astype(np.float32)).all()
    assert (array["block_key"] == np.repeat([key for key, _ in table], [count for _, count in table])).all()
    assert array["rank"].max() == ranks - 1
    if "pressure" in array:
        expected = number(ids, 0).astype(np.float32) + np.float32(k)
        assert (array["pressure"] == expected).all() if k >= 3 else np.isnan(array["pressure"]).all()
    return set(array)


def check_file(path, steps, ranks):
    names = {"id", "velocity", "stress", "rank", "block_key"} | ({"pressure"} if steps > 3 else set())
    reader = reader_of(path)
    assert times_of(reader) == [0.1 * k for k in range(steps)], times_of(reader)
    for k in list(range(steps)) + [0]:
        assert check(reader, k, ranks) == names


def series(writer, folder, *launcher):
    for ranks in (1, 3):
        path = os.path.join(folder, f"particles-{ranks}.vtkhdf")
        for first, last in ((0, 2), (2, 80), (5, 7)):  # start, go on, go on from an earlier time
            command = [*launcher, str(ranks), writer, path, str(first), str(last), str(PARTICLES)]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
            check_file(path, last, ranks)
        print(f"VTK {vtk.vtkVersion().GetVTKVersion()} reads what {ranks} rank(s) wrote")


def kill(count, writer, folder):
    """After a kill at any moment the file has all outputs that were told, and maybe one more."""
    path = os.path.join(folder, "particles.vtkhdf")
    moments = random.Random(7)
    left = 0
    for k in range(int(count)):
        first = left if k % 5 else 0  # some start anew, most go on
        if first == 0 and os.path.exists(path):
            os.remove(path)
        process = subprocess.Popen([writer, path, str(first), "100000", str(PARTICLES)],
                                   stdout=subprocess.PIPE, text=True)
        told = process.stdout.readline()
        time.sleep(moments.uniform(0, 0.05))
        process.send_signal(signal.SIGKILL)
        told += process.stdout.read()
        process.wait()
        reader = reader_of(path)
        left = len(times_of(reader))
        known = first + sum(line.endswith("\n") for line in told.splitlines(True))
        assert known <= left <= known + 1, (known, left)
        for step in {0, left // 2, left - 1}:
            check(reader, step, 1)
    print(f"readable after {count} kills, {left} outputs in the last file")


def main():
    action, arguments = {"series": series, "kill": kill}[sys.argv[1]], sys.argv[2:]
    folder = arguments[1 if action is series else 2]
    np.seterr(over="ignore")
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    action(*arguments)
    shutil.rmtree(folder)


main()
