"""Problems with exact solutions, as scenes of `moraine converge`. Each has quantities of which the exact value is known at a time.

bar      an elastic bar, one end fixed, in its first mode: u = (V / w) sin(b x) sin(w t), b = pi / 2 L, w = b c
column   an elastic column, stress-free, on which its weight begins to act: a series of modes about the settled state; stress has kinks
shear    a shear wave in a viscous fluid with elastic modulus G (Maxwell): v'' + (G / eta) v' + (G k^2 / rho) v = 0, v'(0) = 0
block    a stiff block slides down a slope with friction: x = x0 + v0 t + a t^2 / 2

Strains are at most 1e-5, so that linear solutions are exact to about that.
"""
import math

import numpy

LENGTH, YOUNG, DENSITY, WIDTH = 24.0, 100.0, 1.0, 4.0
SPEED = math.sqrt(YOUNG / DENSITY)
METHODS = {"numerics.shape": ["quadratic", "cubic", "gimp"], "numerics.transfer": ["flip", "apic", "tpic", "fmpm"]}
MODES = 2 * numpy.arange(400) + 1


def solid(gravity, body, walls, end, high):
    return {"dimensions": 2, "gravity": gravity, "domain": {"min": [0.0, 0.0], "max": high, "cell": 1.0},
            "time": {"end": end}, "output": {"interval": 0.02},
            "material": [{"name": "solid", "law": "linear-elastic", "density": DENSITY, "young": YOUNG, "poisson": 0.0}],
            "body": [{"name": "body", "material": "solid", "shape": "box", "min": [0.0, 0.0], **body}],
            "wall": [{"face": face, "kind": kind} for face, kind in walls.items()]}


class Bar:
    V = 1e-4
    times = (1.1, 2.0, 3.3, 4.1, 5.9, 7.0, 9.3)
    scene = solid([0.0, 0.0], {"max": [LENGTH, WIDTH], "wave": {"velocity": [V, 0.0], "axis": "x", "wavelength": 4 * LENGTH}},
                  {"x-min": "no-slip", "y-min": "free-slip", "y-max": "free-slip"}, 9.5, [LENGTH + 4, WIDTH])
    coarsest, methods = (2.0, 1.0), METHODS

    @classmethod
    def exact(cls, t):
        b = math.pi / (2 * LENGTH)
        w, mass = b * SPEED, DENSITY * LENGTH * WIDTH
        return {"kinetic_J": 0.25 * mass * (cls.V * math.cos(w * t))**2, "strain_J": 0.25 * mass * (cls.V * math.sin(w * t))**2,
                "centre_x_m": LENGTH / 2 + 2 / math.pi * cls.V / w * math.sin(w * t), "momentum_x_kg_m_s": mass * 2 / math.pi * cls.V * math.cos(w * t)}


class Column:
    G = 4e-5
    times = (1.0, 2.0, 3.1, 4.3, 5.2, 7.1, 8.2)
    scene = solid([0.0, -G], {"max": [WIDTH, LENGTH]}, {"y-min": "no-slip", "x-min": "free-slip", "x-max": "free-slip"}, 9.0, [WIDTH, LENGTH + 4])
    coarsest, methods = (2.0, 1.0), METHODS

    @classmethod
    def exact(cls, t):
        b = MODES * math.pi / (2 * LENGTH)
        k = DENSITY * cls.G / YOUNG
        a, w = k * 2 / (LENGTH * b**3), b * SPEED
        return {"centre_y_m": LENGTH / 2 - k * LENGTH**2 / 3 + float((a / (b * LENGTH) * numpy.cos(w * t)).sum()),
                "kinetic_J": float((0.25 * DENSITY * WIDTH * LENGTH * (a * w * numpy.sin(w * t))**2).sum()),
                "momentum_y_kg_m_s": float((-DENSITY * WIDTH * a * w / b * numpy.sin(w * t)).sum())}


class Shear:
    V, K, RHO, ETA, E, NU = 1e-3, 2 * math.pi, 1000.0, 10.0, 2.5e5, 0.25
    times = (0.2, 0.5, 0.9, 1.4, 2.0)
    scene = {"dimensions": 2, "domain": {"min": [0.0, 0.0], "max": [1.0, 0.5], "cell": 1 / 32, "periodic": ["x", "y"]}, "time": {"end": 2.1},
             "output": {"interval": 0.005},
             "material": [{"name": "fluid", "law": "newtonian", "density": RHO, "young": E, "poisson": NU, "viscosity": ETA, "volumetric": "particle"}],
             "body": [{"name": "body", "material": "fluid", "shape": "box", "min": [0.0, 0.0], "max": [1.0, 0.5],
                       "wave": {"velocity": [0.0, V], "axis": "x", "wavelength": 1.0}}]}
    coarsest, methods = (1 / 16, 1 / 8), METHODS

    @classmethod
    def exact(cls, t):
        shear = cls.E / (2 * (1 + cls.NU))
        a = shear / cls.ETA
        b = math.sqrt(a * a / 4 - shear * cls.K**2 / cls.RHO)
        slow, fast = a / 2 - b, a / 2 + b
        v = cls.V * (fast * math.exp(-slow * t) - slow * math.exp(-fast * t)) / (2 * b)
        return {"kinetic_J": 0.25 * cls.RHO * 0.5 * v * v}


class Block:
    SLOPE, FRICTION, G = math.radians(24), math.tan(math.radians(15)), 9.81
    times = (0.3, 0.5, 0.7, 0.9)
    scene = {"dimensions": 2, "gravity": [G * math.sin(SLOPE), -G * math.cos(SLOPE)], "domain": {"min": [0.0, -0.1], "max": [2.0, 0.2], "cell": 0.0125},
             "time": {"end": 1.0}, "output": {"interval": 0.005},
             "material": [{"name": "block", "law": "linear-elastic", "density": 1000.0, "young": 1e6, "poisson": 0.3}],
             "body": [{"name": "block", "material": "block", "shape": "box", "min": [0.1, 0.0], "max": [0.2, 0.05], "velocity": [0.1, 0.0],
                       "geostatic": {"surface": 0.05, "k0": 0.0}}],
             "structure": [{"name": "incline", "shape": "plane", "point": [0.0, 0.0], "normal": [0.0, 1.0], "contact": {"law": "coulomb", "friction": FRICTION}}]}
    coarsest, methods = (0.025,), {"numerics.shape": ["quadratic"], "numerics.transfer": ["flip", "apic", "fmpm"]}

    @classmethod
    def exact(cls, t):
        a = cls.G * (math.sin(cls.SLOPE) - cls.FRICTION * math.cos(cls.SLOPE))
        return {"centre_x_m": 0.15 + 0.1 * t + a * t * t / 2, "momentum_x_kg_m_s": 5.0 * (0.1 + a * t)}


PROBLEMS = {"bar": Bar, "column": Column, "shear": Shear, "block": Block}
