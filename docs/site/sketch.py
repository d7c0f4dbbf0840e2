"""Lines, bodies, supports and arrows of a sketch as SVG; places in a box of 480 x 200, y downwards. For draw_evidence.py."""
import html

WIDE, TALL = 480, 200
STYLE = """svg{--ink:#1c1f23;--soil:#d9c7a3;--fluid:#a9cbe8;--solid:#c3c8ce;color:var(--ink)}
@media(prefers-color-scheme:dark){svg{--ink:#e6e8eb;--soil:#7d6a45;--fluid:#33648c;--solid:#5b636c}}
text{font:15px sans-serif;fill:var(--ink)}.edge,.thin{stroke:var(--ink);stroke-width:1.5;fill:none}.thin{stroke-width:1}
.dash{stroke-dasharray:5 4}.soil{fill:var(--soil)}.fluid{fill:var(--fluid)}.solid{fill:var(--solid)}.head{fill:var(--ink);stroke:none}"""


class Sketch:
    def __init__(self, title):
        self.title, self.parts = title, []

    def add(self, part):
        self.parts.append(part)
        return self

    def box(self, x, y, wide, tall, kind="soil"):
        return self.add(f'<rect class="edge {kind}" x="{x}" y="{y}" width="{wide}" height="{tall}"/>')

    def shape(self, points, kind="soil"):
        return self.add(f'<polygon class="edge {kind}" points="{" ".join(f"{x},{y}" for x, y in points)}"/>')

    def disk(self, x, y, radius, kind="solid"):
        return self.add(f'<circle class="edge {kind}" cx="{x}" cy="{y}" r="{radius}"/>')

    def line(self, *points, kind="edge"):
        return self.add(f'<polyline class="{kind}" points="{" ".join(f"{x},{y}" for x, y in points)}"/>')

    def dashed(self, *points):
        return self.line(*points, kind="thin dash")

    def curve(self, path, kind="edge"):
        return self.add(f'<path class="{kind}" d="{path}"/>')

    def ground(self, x0, y0, x1, y1, side=1):
        """A support with strokes on its far side (1: below a line that runs to the right)."""
        self.line((x0, y0), (x1, y1))
        length = ((x1 - x0) ** 2 + (y1 - y0) ** 2) ** 0.5
        tx, ty = (x1 - x0) / length, (y1 - y0) / length
        nx, ny = -ty * side, tx * side
        stroke = f"l{-6 * tx + 8 * nx:.3g},{-6 * ty + 8 * ny:.3g}"
        begins = ((x0 + tx * 12 * k, y0 + ty * 12 * k) for k in range(int(length // 12) + 1))
        self.curve("".join(f"M{x:.4g},{y:.4g}{stroke}" for x, y in begins), kind="thin")
        return self

    def arrow(self, x0, y0, x1, y1, words="", dx=6, dy=-4, both=False):
        self.line((x0, y0), (x1, y1), kind="thin")
        for (ax, ay), (bx, by) in (((x0, y0), (x1, y1)), ((x1, y1), (x0, y0)))[:2 if both else 1]:
            length = ((bx - ax) ** 2 + (by - ay) ** 2) ** 0.5
            tx, ty = (bx - ax) / length, (by - ay) / length
            corners = [(bx, by), (bx - 9 * tx - 4 * ty, by - 9 * ty + 4 * tx), (bx - 9 * tx + 4 * ty, by - 9 * ty - 4 * tx)]
            self.add(f'<polygon class="head" points="{" ".join(f"{x:.1f},{y:.1f}" for x, y in corners)}"/>')
        return self.text((x0 + x1) / 2 + dx, (y0 + y1) / 2 + dy, words) if words else self

    def measure(self, x0, y0, x1, y1, words, dx=6, dy=-4):
        return self.arrow(x0, y0, x1, y1, words, dx, dy, both=True)

    def text(self, x, y, words, anchor="start"):
        return self.add(f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}">{html.escape(words)}</text>')

    def svg(self):
        inside = "\n".join(self.parts)
        return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDE} {TALL}" width="{WIDE}" height="{TALL}" role="img">\n'
                f"<title>{html.escape(self.title)}</title>\n<style>{STYLE}</style>\n{inside}\n</svg>\n")
