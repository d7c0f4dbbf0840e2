"""Writes the slurry's dam break as a case of OpenFOAM's interFoam (volume of fluid), runs it, and reads what it wrote.

Two incompressible fluids in one velocity field, alpha the slurry's share of a cell. Bingham of `HerschelBulkley`: nu = min(nu0, tau0 / g + k g^(n-1)) with
g = sqrt(2 D:D), so that sqrt(J2) = yield_stress + viscosity g above the yield stress: Moraine's `bingham`, factor 1, per density. Below g =
yield_stress / (density nu0) it creeps, where Moraine is elastic. The mesh is an L, high over the reservoir and low in front of it; cells are h long and, at
the bed, half as high. Where the front meets the bed, no-slip holds on the wall's face only: the lowest cell moves over it.
"""
import math
import os
import re
import shutil
import subprocess
import time

import numpy

CORNER, LOW, TOP = 20.0, 2.4, 6.0  # of the L [m]
BEHIND = 1.0  # the front, where air counts as trapped [m]
INSIDE = re.compile(r"internalField\s+nonuniform\s+List<(\w+)>\s*\d+\s*\((.*)\)\s*;\s*boundaryField", re.DOTALL)
HEADER = "FoamFile {{ version 2.0; format ascii; class {kind}; location \"{place}\"; object {name}; }}\n"
MESH = """\
vertices ( {vertices} );
blocks
(
    hex (0 1 4 3 8 9 12 11) ({near} {low} 1) simpleGrading (1 {rise:g} 1)
    hex (1 2 5 4 9 10 13 12) ({far} {low} 1) simpleGrading (1 {rise:g} 1)
    hex (3 4 7 6 11 12 15 14) ({near} {high} 1) simpleGrading (1 1 1)
);
boundary
(
    back {{ type wall; faces ((0 8 11 3) (3 11 14 6)); }}
    bed {{ type wall; faces ((0 1 9 8) (1 2 10 9)); }}
    far {{ type wall; faces ((2 5 13 10) (4 7 15 12)); }}
    air {{ type patch; faces ((5 4 12 13) (7 6 14 15)); }}
    sides {{ type empty; faces ((0 3 4 1) (1 4 5 2) (3 6 7 4) (8 9 12 11) (9 10 13 12) (11 12 15 14)); }}
);
"""
TRANSPORT = """\
phases (slurry air);
slurry
{{
    transportModel HerschelBulkley;
    HerschelBulkleyCoeffs {{ nu0 {nu0!r}; tau0 {tau0!r}; k {k!r}; n 1; }}
    rho {density!r};
}}
air {{ transportModel Newtonian; nu {nu_air!r}; rho {air_density!r}; }}
sigma 0;
"""
CONTROL = """\
application interFoam;
startFrom startTime; startTime 0; stopAt endTime; endTime {end!r};
deltaT 1e-4; adjustTimeStep yes; maxCo {courant!r}; maxAlphaCo {courant!r}; maxDeltaT 0.05;
writeControl adjustableRunTime; writeInterval {interval!r}; writeFormat ascii; writePrecision 8; writeCompression off; timeFormat general;
"""
SCHEMES = """\
ddtSchemes { default Euler; }
gradSchemes { default Gauss linear; }
divSchemes
{
    default Gauss linear;
    div(rhoPhi,U) Gauss linearUpwind grad(U);
    div(phi,alpha) Gauss vanLeer;
}
laplacianSchemes { default Gauss linear uncorrected; }
interpolationSchemes { default linear; }
snGradSchemes { default uncorrected; }
"""
SOLUTION = """\
solvers
{{
    "alpha.slurry.*" {{ nAlphaCorr 2; nAlphaSubCycles 1; cAlpha {compression!r}; MULESCorr no; }}
    "pcorr.*" {{ solver PCG; preconditioner DIC; tolerance 1e-6; relTol 0; }}
    "p_rgh.*" {{ solver {pressure}; tolerance 1e-7; relTol 0.02; }}
    p_rghFinal {{ solver {pressure}; tolerance 1e-8; relTol 0; }}
    "U.*" {{ solver PBiCGStab; preconditioner DILU; tolerance 1e-8; relTol 0; }}
}}
PIMPLE {{ momentumPredictor yes; nOuterCorrectors {outer}; nCorrectors 3; nNonOrthogonalCorrectors 0; }}
relaxationFactors {{ equations {{ ".*" 1; }} }}
"""
PRESSURE = "GAMG; smoother GaussSeidel"
STILL = {"back": "slip", "bed": "noSlip", "far": "slip", "air": "pressureInletOutletVelocity; value uniform (0 0 0)"}
WALLS = {"back": "zeroGradient", "bed": "zeroGradient", "far": "zeroGradient", "air": "inletOutlet; inletValue uniform 0; value uniform 0"}
LOADS = {"back": "fixedFluxPressure; value uniform 0", "bed": "fixedFluxPressure; value uniform 0", "far": "fixedFluxPressure; value uniform 0",
         "air": "totalPressure; p0 uniform 0; value uniform 0"}


class Mesh:
    """Edges of cells: rows of the low part from the bed up, rows of the high part, columns."""

    def __init__(self, h, length, rise):
        """`rise`: height of the low part's last row over that of the row at the bed, which is h / rise."""
        self.near, self.far, self.high = round(CORNER / h), round((length - CORNER) / h), round((TOP - LOW) / h)
        if any(abs(part / h - round(part / h)) > 1e-9 for part in (CORNER, length - CORNER, TOP - LOW)):
            raise ValueError(f"cells of {h:g} m do not divide {CORNER:g}, {length - CORNER:g} and {TOP - LOW:g} m")
        mean = (1 - 1 / rise) / math.log(rise) if rise > 1 else 1  # of the heights, over h
        heights = rise ** numpy.linspace(0, 1, round(LOW / (mean * h)))
        self.y_low = numpy.concatenate(([0.0], LOW * numpy.cumsum(heights) / heights.sum()))
        self.y_high = numpy.linspace(LOW, TOP, self.high + 1)
        self.h, self.length, self.rise = h, length, rise

    def text(self):
        plane = [(0, 0), (CORNER, 0), (self.length, 0), (0, LOW), (CORNER, LOW), (self.length, LOW), (0, TOP), (CORNER, TOP)]
        vertices = " ".join(f"({x:g} {y:g} {z:g})" for z in (0, 1) for x, y in plane)
        return MESH.format(vertices=vertices, near=self.near, far=self.far, low=len(self.y_low) - 1, high=self.high, rise=self.rise)

    def cells(self):
        """(x of the left edge, y of the lower edge, height) of all cells, in the mesh's order."""
        parts = [(0.0, self.near, self.y_low), (CORNER, self.far, self.y_low), (0.0, self.near, self.y_high)]
        found = []
        for left, columns, edges in parts:
            x, y = numpy.meshgrid(left + self.h * numpy.arange(columns), edges[:-1])
            found.append((x.ravel(), y.ravel(), numpy.repeat(numpy.diff(edges), columns)))
        return [numpy.concatenate(c) for c in zip(*found)]


def field(name, kind, dimensions, inside, patches):
    """A field's file."""
    walls = " ".join(f"{patch} {{ type {words}; }}" for patch, words in patches.items())
    return HEADER.format(kind=kind, place="0", name=name) + f"dimensions {dimensions};\ninternalField {inside};\nboundaryField {{ {walls} sides {{ type empty; }} }}\n"


def write(folder, mesh, scene, choices):
    """`scene`: density, viscosity, yield_stress, width, height of the block; `choices`: what is the peer's own."""
    x, y, high = mesh.cells()
    alpha = numpy.where(x + 0.5 * mesh.h < scene["width"], numpy.clip((scene["height"] - y) / high, 0, 1), 0)
    listed = f"nonuniform List<scalar> {len(alpha)} ( " + "\n".join(f"{a:.8g}" for a in alpha) + " )"
    rho = scene["density"]
    transport = TRANSPORT.format(nu0=choices["creep_viscosity"] / rho, tau0=scene["yield_stress"] / rho, k=scene["viscosity"] / rho, density=rho,
                                 nu_air=choices["air_viscosity"] / choices["air_density"], air_density=choices["air_density"])
    texts = {"system/blockMeshDict": mesh.text(), "system/fvSchemes": SCHEMES, "constant/transportProperties": transport,
             "system/controlDict": CONTROL.format(**choices), "system/fvSolution": SOLUTION.format(pressure=PRESSURE, **choices),
             "constant/turbulenceProperties": "simulationType laminar;\n", "constant/g": "dimensions [0 1 -2 0 0 0 0];\nvalue (0 -9.81 0);\n"}
    for name, text in texts.items():
        place, _, stem = name.partition("/")
        (folder / place).mkdir(parents=True, exist_ok=True)
        kind = "uniformDimensionedVectorField" if stem == "g" else "dictionary"
        (folder / name).write_text(HEADER.format(kind=kind, place=place, name=stem) + text)
    (folder / "0").mkdir(exist_ok=True)
    (folder / "0/alpha.slurry").write_text(field("alpha.slurry", "volScalarField", "[0 0 0 0 0 0 0]", listed, WALLS))
    (folder / "0/U").write_text(field("U", "volVectorField", "[0 1 -1 0 0 0 0]", "uniform (0 0 0)", STILL))
    (folder / "0/p_rgh").write_text(field("p_rgh", "volScalarField", "[1 -1 -2 0 0 0 0]", "uniform 0", LOADS))


def start(program, folder, home):
    with open(folder / f"{program}.log", "a") as log:
        subprocess.run([program, "-case", str(folder)], stdout=log, stderr=log, check=True, env=dict(os.environ, WM_PROJECT_DIR=home))


def run(folder, home, mesh, choices):
    """(version, steps, seconds) of blockMesh and interFoam; raises CalledProcessError where one fails."""
    begun = time.monotonic()
    start("blockMesh", folder, home)
    if choices["lift"]:
        run_lifting(folder, home, mesh, choices)
    else:
        start("interFoam", folder, home)
    log = (folder / "interFoam.log").read_text()
    return "OpenFOAM " + re.search(r"Build *: *\w+=(\S+)", log)[1], len(re.findall(r"^Time = ", log, re.M)), round(time.monotonic() - begun, 1)


def run_lifting(folder, home, mesh, choices):
    """interFoam in pieces of `lift` seconds, between which air that is trapped at the bed goes to the surface of its column."""
    for k in range(1, round(choices["end"] / choices["lift"]) + 1):
        now, before = (f"{n * choices['lift']:.6g}" for n in (k, k - 1))
        piece = CONTROL.format(**{**choices, "end": float(now), "interval": choices["lift"]}).replace("startFrom startTime; startTime 0", "startFrom latestTime")
        (folder / "system/controlDict").write_text(HEADER.format(kind="dictionary", place="system", name="controlDict") + piece)
        start("interFoam", folder, home)
        if abs(float(before) / choices["interval"] - round(float(before) / choices["interval"])) > 1e-6:
            shutil.rmtree(folder / before)
        path = folder / now / "alpha.slurry"
        listed = "\n".join(f"{a:.8g}" for a in lifted(read(path), mesh))
        path.write_text(INSIDE.sub(lambda m: f"internalField nonuniform List<scalar> {len(mesh.cells()[0])} ( {listed} ) ; boundaryField", path.read_text()))


def lifted(alpha, mesh):
    """alpha with full cells in the two lowest rows, up to BEHIND the front; what they take comes from the top of their column, so that columns keep their volume."""
    x, y, high = mesh.cells()
    alpha, columns = alpha.copy(), numpy.round(x / mesh.h).astype(int)
    sums = numpy.cumsum(numpy.bincount(columns, alpha * high))
    last = int((mesh.h * numpy.searchsorted(sums, 0.995 * sums[-1]) - BEHIND) / mesh.h)
    for column in range(last):
        rows = numpy.flatnonzero(columns == column)
        rows = rows[numpy.argsort(y[rows])]
        low, above = rows[:2], rows[2:]
        lacks = ((1 - alpha[low]) * high[low]).sum()
        if lacks < 1e-9 or (alpha[above] * high[above]).sum() < lacks:
            continue
        alpha[low] = 1
        for cell in above[::-1]:
            taken = min(lacks, alpha[cell] * high[cell])
            alpha[cell] -= taken / high[cell]
            lacks -= taken
    return alpha


def read(path):
    """Values of the cells of an ASCII field, a row of three for a vector."""
    text = path.read_text()
    found = INSIDE.search(text)
    values = numpy.array(found[2].replace("(", " ").replace(")", " ").split(), dtype=float)
    return values.reshape(-1, 3) if found[1] == "vector" else values
