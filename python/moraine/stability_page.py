"""stability.html: brackets, ways of all trials over time, and where the slope slides, on one page; slip-cell-*.png beside it."""
import base64
import html
import pathlib
import shutil
import tempfile
from typing import List

from .drawing import draw
from .errors import Error
from .page_text import Axes, page, table, warning
from .results import Run
from .slope_result import FactorOfSafety, SlopeResult
from .stability_text import answer, bracket_rows, warnings_of
from .verdict import STANDS, WAY


def _picture_field(run: Run) -> str:
    """Where it slides: plastic shear strain, of laws that remember it, else speed."""
    with run.particles as series:
        return "plastic_shear_strain" if "plastic_shear_strain" in series.fields else "speed"


def write_pictures(found: FactorOfSafety) -> None:
    """slip-cell-*.png of each cell: the run at the lowest factor that fails, its last output. Without matplotlib none, and a remark."""
    for level in found.levels:
        run = found.path / level.folder / f"F-{level.fails:g}"
        with tempfile.TemporaryDirectory(prefix="moraine-") as folder:
            try:
                files = draw(run, _picture_field(Run(run)), [float(Run(run).particles.times[-1])], output=folder, animate=False)
            except Error as missing:
                found.remarks.append(f"the slip surface is not drawn: {missing}")
                return
            name = f"slip-{level.folder}.png"
            shutil.copyfile(files[0], found.path / name)
            level.picture = name


def _ways(level: SlopeResult) -> str:
    """The way over H of all trials, over time; those beyond twice the largest that stands are cut there."""
    most = 2 * max((max(trial.ways) / level.height for trial in level.trials if trial.verdict == STANDS), default=WAY)
    lines = [(trial.times, [min(way / level.height, most) for way in trial.ways]) for trial in level.trials if len(trial.times) > 1]
    if not lines:
        return ""
    axes = Axes([0.0, max(times[-1] for times, _ in lines)], [0.0, max(max(ways) for _, ways in lines)])
    for times, ways in lines:
        axes.line(times, ways)
    return f"<figure><h3>cell {level.cell:.6g} m</h3>{axes.svg('time since strengths were reduced [s]', 'way / H')}</figure>"


def _trial_rows(level: SlopeResult) -> List[List[str]]:
    rows = [["F", "verdict", "way [m]", "way / H", "after [s]"]]
    for trial in level.trials:
        rows.append([f"{trial.factor:g}", trial.verdict, f"{trial.ways[-1]:.3g}", f"{trial.ways[-1] / level.height:.3g}", f"{trial.times[-1]:.3g}"])
    return rows


def write_page(found: FactorOfSafety) -> pathlib.Path:
    """stability.html in the folder of the search; the file."""
    parts = [warning(warnings_of(found)), f"<p><b>{html.escape(answer(found))}</b></p>", table(bracket_rows(found)), "<h2>Where it slides</h2>"]
    for level in found.levels:
        if level.picture:
            data = base64.b64encode((found.path / level.picture).read_bytes()).decode()
            words = f"F = {level.fails:g}, the lowest that fails, cell {level.cell:.6g} m"
            parts.append(f'<figure><img alt="{words}" src="data:image/png;base64,{data}"><figcaption>{words}</figcaption></figure>')
    parts += ["<h2>How far it went</h2>", f'<div class="cards">{"".join(map(_ways, found.levels))}</div>']
    for level in found.levels:
        parts += [f"<h3>cell {level.cell:.6g} m</h3>", table(_trial_rows(level))]
    path = found.path / "stability.html"
    path.write_text(page(f"Factor of safety of {found.scene}", [part for part in parts if part]), encoding="utf-8")
    return path
