"""matplotlib as plots of a report want it: files only, one style."""
import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as pyplot  # noqa: E402, F401  (the backend comes first; charts and plots take it from here)

matplotlib.rcParams.update({
    "svg.fonttype": "none", "svg.hashsalt": "moraine", "font.family": "DejaVu Sans", "font.size": 9.5,
    "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "grid.alpha": 0.25,
    "axes.titlesize": 10.5, "legend.frameon": False, "figure.constrained_layout.use": True,
})
