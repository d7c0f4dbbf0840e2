"""Files of figures: PNG, and animations: a GIF always, an MP4 where ffmpeg is."""
import pathlib
from typing import Any, Callable, List, Sequence

import matplotlib.animation
import numpy
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image


def save(figure: Any, path: pathlib.Path) -> None:
    """As PNG of at most 256 colours, which is a third of the size."""
    figure.set_dpi(100)
    FigureCanvasAgg(figure).draw()
    colours = Image.fromarray(numpy.asarray(figure.canvas.buffer_rgba())).convert("RGB")
    colours.quantize(256, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(path, optimize=True)


def animate(frames: Any, ks: Sequence[int], stem: pathlib.Path, told: Callable[[str], None]) -> List[pathlib.Path]:
    """Outputs `ks` as stem.gif and, with ffmpeg, stem.mp4: each for 1/8 s, the last for a second. Returns the files."""
    writers = [(stem.with_name(stem.name + ".gif"), matplotlib.animation.PillowWriter(fps=8))]
    if matplotlib.animation.FFMpegWriter.isAvailable():  # H.264 takes even numbers of pixels only
        even = ["-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white", "-pix_fmt", "yuv420p"]
        writers.append((stem.with_name(stem.name + ".mp4"), matplotlib.animation.FFMpegWriter(fps=8, codec="libx264", extra_args=even)))
    for done, k in enumerate(ks):
        figure = frames.figure(k)
        figure.set_dpi(80)
        for path, writer in writers:
            if done == 0:
                writer.setup(figure, str(path), dpi=80)
            writer.fig = figure
            for _ in range(9 if done + 1 == len(ks) else 1):
                writer.grab_frame()
        if (done + 1) % 10 == 0 and done + 1 < len(ks):
            told(f"{writers[0][0]}  frame {done + 1} of {len(ks)}")
    for path, writer in writers:
        writer.finish()
        told(f"{path}  {len(ks)} frames")
    return [path for path, _ in writers]
