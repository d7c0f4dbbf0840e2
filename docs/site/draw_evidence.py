#!/usr/bin/env python3
"""Sketches of the problems of docs/evidence, and bars of measured over limit for pages that have no other plot.

    docs/site/draw_evidence.py          # writes docs/evidence/*.svg; a test compares them
"""
import html
import math
import pathlib
import re

from sketch import STYLE, WIDE, Sketch

PAGES = pathlib.Path(__file__).resolve().parents[1] / "evidence"


def vibrating_bar(s):
    s.ground(60, 60, 60, 140).box(60, 80, 330, 40, "solid").arrow(400, 100, 450, 100, "v(x)", -14, -8)
    s.curve("M60,165 Q225,165 390,135", "thin dash").text(225, 185, "velocity at the start: a quarter of a wave", "middle")
    s.text(30, 55, "fixed").text(372, 70, "free")


def manufactured_displacement(s):
    s.box(120, 40, 240, 120, "solid").curve("M120,100 C150,40 210,40 240,100 S330,160 360,100")
    s.text(240, 28, "u(x, t) given, and the body force that belongs to it", "middle").measure(120, 178, 360, 178, "one wavelength", -40, 16)
    s.text(50, 104, "periodic").text(372, 104, "or walls")


def column(s):
    s.ground(150, 180, 290, 180).box(180, 40, 80, 140, "solid").arrow(340, 60, 340, 120, "g", 8, 4)
    s.measure(150, 40, 150, 180, "l0", -22, 4).line((260, 40), (300, 180), kind="thin dash").text(306, 160, "stress")


def vortex(s):
    s.box(140, 10, 180, 180, "solid").disk(230, 100, 70, "soil").disk(230, 100, 34, "solid")
    s.curve("M178,78 A58,58 0 0 1 268,56", "edge").arrow(258, 50, 270, 60).text(330, 80, "a ring is turned by").text(330, 98, "1/3 rad and back,").text(330, 116, "and sheared by 2")


def projectile(s):
    s.box(40, 120, 40, 40, "solid").curve("M60,130 Q240,-60 430,140", "thin dash").box(410, 130, 40, 40, "solid").arrow(80, 112, 120, 72, "v", -14, -6)
    s.arrow(240, 90, 240, 150, "g", 8, 4).text(210, 180, "10 300 cells of flight")


def turning_square(s):
    s.shape([(230, 30), (300, 100), (230, 170), (160, 100)], "solid").box(180, 50, 100, 100, "none").curve("M320,70 A110,110 0 0 1 320,130", "edge")
    s.arrow(322, 122, 318, 134).text(340, 104, "3.2 turns in 20 s")


def block_on_a_plane(s):
    s.ground(40, 60, 420, 180).shape([(130, 55), (225, 85), (211, 114), (116, 88)], "solid").arrow(240, 92, 300, 111, "v", 6, -4)
    s.arrow(400, 40, 400, 100, "g", 8, 4).text(30, 150, "at rest, sliding with tan 15,").text(30, 168, "sticking; plane and grid turned")


def layers_on_a_bed(s):
    s.ground(30, 60, 220, 120).shape([(50, 54), (190, 98), (187, 110), (46, 66)], "soil").text(70, 40, "0.4 to 8 cells thick")
    s.disk(350, 150, 60, "solid").curve("M296,124 A60,60 0 0 1 404,124 L414,119 A71,71 0 0 0 286,119 Z", "edge soil").text(350, 66, "or on a cylinder", "middle")


def ground_from_heights(s):
    s.curve("M30,30 Q180,170 450,175").shape([(95, 70), (125, 96), (113, 110), (83, 84)], "soil").arrow(128, 104, 170, 136, "v", 6, -2)
    for x, y in ((60, 55), (90, 78), (120, 98), (160, 121), (200, 138), (260, 155), (320, 166), (400, 173)):
        s.line((x, y), (x, 190), kind="thin dash")
    s.text(220, 50, "a row of heights,").text(220, 68, "Coulomb's or Voellmy's law")


def pipe(s):
    s.ground(60, 190, 420, 190).box(60, 90, 360, 100, "soil").disk(240, 95, 40, "solid").arrow(240, 20, 240, 52, "V, 0.05 m/s", 8, -2)
    s.measure(310, 90, 310, 135, "w", 6, 4).text(80, 150, "clay, su").text(236, 100, "D")


def films(s):
    s.ground(40, 60, 420, 170).shape([(40, 30), (420, 140), (420, 168), (40, 58)], "fluid").arrow(180, 106, 250, 126).arrow(180, 94, 290, 126).arrow(180, 82, 310, 120)
    s.text(300, 50, "no slip at the base,").text(300, 68, "20 cells deep").arrow(120, 120, 120, 176, "g", 8, 4)


def columns_of_sand(s):
    s.ground(40, 180, 440, 180).ground(60, 180, 60, 20, -1).box(60, 40, 70, 140, "soil").curve("M60,130 Q150,160 330,180", "thin dash")
    s.measure(60, 28, 130, 28, "L0", -8, -6).measure(150, 40, 150, 180, "H = a L0", 6, 0).measure(130, 170, 330, 170, "runout", -20, -8)


def strip_footing(s):
    s.ground(50, 190, 430, 190).box(50, 80, 380, 110, "soil").box(190, 60, 100, 20, "solid").arrow(240, 15, 240, 58, "V", 8, -8)
    s.measure(190, 50, 290, 50, "B", 30, -4).curve("M190,80 Q240,140 290,80", "thin dash").curve("M290,80 Q330,170 390,80", "thin dash").curve("M190,80 Q150,170 90,80", "thin dash")
    s.text(60, 170, "clay without weight, su")


def tbar(s):
    s.box(130, 20, 220, 170, "soil").disk(240, 90, 32, "solid").arrow(240, 122, 240, 166, "0.05 m/s", 8, 4).curve("M200,60 C190,90 195,120 215,140", "thin dash")
    s.curve("M280,60 C290,90 285,120 265,140", "thin dash").measure(208, 90, 272, 90, "D", -6, -4).text(362, 90, "full flow of clay").text(362, 108, "under 40 su")


def slurry(s):
    s.ground(30, 180, 460, 180).ground(40, 180, 40, 40, -1).box(40, 80, 140, 100, "fluid").line((180, 50), (180, 180)).text(150, 40, "gate, gone at once")
    s.curve("M40,140 Q200,160 440,180", "thin dash").measure(40, 68, 140, 68, "10 m", 8, -4).measure(196, 80, 196, 180, "H0 = 5 m", 6, 4).text(270, 90, "yields at 0.0068 rho g H0")


def slump(s):
    s.ground(85, 180, 400, 180).box(160, 40, 140, 140, "none").curve("M105,180 C125,150 140,120 165,112 L295,112 C320,120 335,150 355,180 Z", "edge fluid").line((230, 28), (230, 190), kind="thin dash")
    s.measure(70, 40, 70, 180, "H = D", -52, 4).measure(320, 40, 320, 112, "s", 6, 4).dashed((300, 40), (330, 40)).text(350, 90, "yields under").text(350, 108, "its own weight")


def cantilever(s):
    s.ground(70, 10, 70, 100).box(70, 40, 300, 24, "none").curve("M70,40 C180,40 265,90 295,170 L273,178 C245,105 175,64 70,64 Z", "edge solid").arrow(420, 60, 420, 120, "g", 8, 4)
    s.measure(70, 26, 370, 26, "L = 10 D", -28, -6).measure(335, 52, 335, 174, "sinking of the tip", 6, 40).dashed((284, 174), (345, 174)).dashed((70, 52), (370, 52)).text(12, 56, "clamp")


def viscous_current(s):
    s.ground(30, 180, 460, 180).box(40, 110, 70, 70, "fluid").curve("M40,140 C200,142 330,150 380,180", "thin dash").text(130, 100, "0.1 m x 0.1 m of syrup")
    s.arrow(360, 160, 430, 160, "x ~ t^(1/5)", -20, -8)


def wet_bed(s):
    s.ground(30, 180, 460, 180).box(40, 70, 200, 110, "fluid").box(240, 136, 210, 44, "fluid").line((240, 40), (240, 180))
    s.text(250, 50, "gate, gone at once").measure(60, 70, 60, 180, "1 m", 6, 4).measure(430, 136, 430, 180, "0.4 m", -48, 4).dashed((130, 70), (240, 105), (340, 105), (340, 136))


def tank(s):
    s.ground(90, 180, 390, 180).ground(90, 180, 90, 40, -1).ground(390, 180, 390, 40).curve("M90,70 Q165,70 240,85 T390,100 L390,180 L90,180 Z", "edge fluid")
    s.dashed((90, 85), (390, 85)).text(180, 140, "smooth walls").text(200, 56, "0.02 m cos(pi x / 2 m)")


def taylor_green(s):
    s.box(150, 10, 180, 180, "fluid").curve("M240,40 A60,60 0 1 1 239,40", "edge").curve("M240,70 A30,30 0 1 1 239,70", "edge").arrow(232, 40, 246, 41).arrow(232, 70, 246, 71)
    s.text(345, 80, "one vortex,").text(345, 98, "Re = 200,").text(345, 116, "smooth walls")


def random_scenes(s):
    s.box(40, 30, 90, 60, "soil").shape([(180, 30), (250, 45), (225, 95), (170, 80)], "fluid").disk(340, 65, 35, "solid").box(400, 20, 40, 40, "soil")
    s.ground(30, 180, 450, 180).shape([(60, 180), (200, 180), (260, 165), (70, 165)], "fluid").text(200, 152, "shape, transfer, law, walls, step")
    for x, y in ((150, 120), (170, 135), (330, 130), (360, 118), (300, 125)):
        s.disk(x, y, 3, "fluid")


def error_bars(s):
    for k, (x, cells) in enumerate(((60, 2), (190, 4), (320, 8))):
        s.box(x, 60, 100, 100, "none")
        for n in range(1, cells):
            s.line((x + 100 * n / cells, 60), (x + 100 * n / cells, 160), kind="thin").line((x, 60 + 100 * n / cells), (x + 100, 60 + 100 * n / cells), kind="thin")
    s.text(240, 45, "three levels, a value on each, an error bar of the finest", "middle")


def ranks_that_follow(s):
    s.ground(30, 90, 450, 90).ground(30, 180, 450, 180)
    for x, wide, kind in ((40, 30, "soil"), (70, 30, "fluid"), (100, 30, "solid"), (130, 30, "soil")):
        s.box(x, 30, wide, 60, kind)
    for x, wide, tall, kind in ((40, 60, 35, "soil"), (100, 80, 28, "fluid"), (180, 100, 22, "solid"), (280, 140, 16, "soil")):
        s.box(x, 180 - tall, wide, tall, kind)
    s.text(200, 60, "start: each rank a quarter").text(300, 135, "later: still a quarter")


SKETCHES = {
    "vibrating-bar": vibrating_bar, "manufactured-displacement": manufactured_displacement, "column-under-its-own-weight": column, "vortex": vortex,
    "projectile": projectile, "turning-square": turning_square, "block-on-a-plane": block_on_a_plane, "layers-on-a-bed": layers_on_a_bed,
    "ground-from-heights": ground_from_heights, "pipe-penetration": pipe, "films-on-an-incline": films, "columns-of-sand": columns_of_sand,
    "strip-footing": strip_footing, "t-bar": tbar, "slurry-runout": slurry, "slump-of-a-cylinder": slump, "large-deflection-of-a-cantilever": cantilever, "viscous-current": viscous_current, "dam-break-onto-a-wet-bed": wet_bed,
    "sloshing-tank": tank, "taylor-green-vortex": taylor_green, "random-scenes": random_scenes, "error-bars": error_bars, "ranks-that-follow": ranks_that_follow,
}


def sketch(name):
    found = Sketch(name.replace("-", " "))
    SKETCHES[name](found)
    return found.svg()


NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def rows_of(page):
    """What, measured, limit of the table of results, where both are numbers."""
    lines = [line for line in page.split("## Result", 1)[1].splitlines() if line.startswith("|")]
    found = []
    for line in lines[2:]:
        what, measured, limit = [cell.strip() for cell in line.strip("|").split("|")][:3]
        if NUMBER.search(measured) and NUMBER.search(limit):
            found.append((what, *(abs(float(NUMBER.search(cell)[0])) for cell in (measured, limit))))
    return found


def bars(title, page):
    """Measured over limit, by powers of ten: left of the line is within it."""
    rows = rows_of(page)
    least = min(-1.0, *(math.log10(max(measured, 1e-18) / limit) for _, measured, limit in rows))
    low, high = math.floor(max(least, -16)), 1
    left, right, parts = 24, WIDE - 40, []
    place = lambda power: left + (power - low) / (high - low) * (right - left)  # noqa: E731
    every = max(1, (high - low) // 5)
    tall = 44 * len(rows) + 46
    for power in range(low, high + 1):
        if power % every == 0:
            parts.append(f'<line class="thin{"" if power == 0 else " dash"}" x1="{place(power):.1f}" x2="{place(power):.1f}" y1="6" y2="{tall - 40}"/>'
                         f'<text x="{place(power):.1f}" y="{tall - 24}" text-anchor="middle">{"limit" if power == 0 else f"1e{power}"}</text>')
    for k, (what, measured, limit) in enumerate(rows):
        at = place(min(high, max(low, math.log10(max(measured, 1e-18) / limit))))
        parts.append(f'<rect class="edge fluid" x="{left}" y="{44 * k + 28}" width="{at - left:.1f}" height="14"/>'
                     f'<text class="over" x="{left}" y="{44 * k + 22}">{html.escape(what)}</text>')
    parts.append(f'<text x="{right}" y="{tall - 5}" text-anchor="end">measured over limit</text>')
    inside = "\n".join(parts)
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDE} {tall}" width="{WIDE}" height="{tall}" role="img">\n'
            f"<title>{html.escape(title)}: measured over limit</title>\n<style>{STYLE}</style>\n{inside}\n</svg>\n")


def pictures():
    """File names and texts of all drawings."""
    found = {}
    for name in SKETCHES:
        found[f"{name}.svg"] = sketch(name)
        page = (PAGES / f"{name}.md").read_text(encoding="utf-8")
        if f"]({name}-bars.svg)" in page:
            found[f"{name}-bars.svg"] = bars(name.replace("-", " "), page)
    return found


if __name__ == "__main__":
    for file, text in pictures().items():
        (PAGES / file).write_text(text, encoding="utf-8")
