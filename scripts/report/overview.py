"""The first page of a run over terrain, for who decides: what was asked, the maps, places and lines, mass, travel angle, and how sure it is."""
import html
import json
import math
import pathlib
import time

import page

FEW = 4       # cells over a release or an inflow, from which on a flow is resolved
LIMITS = ("Nothing is taken up from the bed, and the ground does not move.", "Parameters are those of one run: a range of them is a study (moraine study).",
          "Depths below the threshold and what flies are no depth.")
LAW = ("friction", "xi", "su", "alpha", "density")


def number(value, unit="", digits=4):
    return f"{value:.{digits}g}{unit}" if isinstance(value, (int, float)) and math.isfinite(value) else "not known"


def scene_of(run):
    try:
        found = json.loads((run.path / "scene.json").read_text(encoding="utf-8"))
        return found if isinstance(found, dict) and isinstance(found.get("hazard"), dict) else None
    except (OSError, ValueError):
        return None


def system_name(crs):
    """The name in a coordinate system's WKT."""
    return crs.split('"')[1] if isinstance(crs, str) and crs.count('"') > 1 else "none is known"


def parameters(keys, prefix, names=None):
    """Keys below a prefix, as words."""
    found = {key[len(prefix):]: value for key, value in keys.items() if key.startswith(prefix)}
    chosen = names if names is not None else [name for name in found if name not in ("law", "volumetric", "matching")]
    return ", ".join(f"{name} {found[name]}" for name in chosen if name in found and found[name] not in ("0", "particle"))


def asked(run, scene):
    """Rows of what the run was of."""
    keys, ground = scene.get("keys", {}), next((s for s in scene.get("structure", []) if s.get("shape") == "ground"), {})
    cell = scene["domain"]["cell"]
    rows = []
    for source in scene.get("source", []):
        cells = source["thickness_m"] / cell
        start = f", at {source['start_s']:g} s" if source.get("start_s") else ""
        rows.append((f"{source['kind']} {source['name']}", f"{source['volume_m3']:.4g} m3{start}, {source['thickness_m']:.3g} m thick at most: {cells:.3g} cells"
                     + ("" if cells >= FEW else " (TOO FEW: fewer than 4 do not resolve a flow)")))
    names = {key.split(".")[1] for key in keys if key.startswith("material.")}
    rows += [(f"material {name}", f"{keys.get(f'material.{name}.law')}: {parameters(keys, f'material.{name}.')}") for name in sorted(names)]
    bed = f"structure.{ground.get('name', 'terrain')}.contact."
    rows.append(("bed", f"{keys.get(bed + 'law', 'not known')}: {parameters(keys, bed, LAW)}"))
    file = pathlib.Path(ground.get("file", ""))
    there = time.strftime("%Y-%m-%d", time.gmtime(file.stat().st_mtime)) if file.is_file() else "no more where the run found it"
    rows += [("model of heights", f"{file.name} ({there}), {number(ground.get('spacing'), ' m')} apart"), ("coordinates", system_name(ground.get("crs"))),
             ("cells", f"{cell:g} m; maps {scene['hazard']['cell']:g} m, reached from {scene['hazard']['threshold']:g} m on"),
             ("program", f"{run.summary.get('version', '')}, commit {run.summary.get('commit', 'not recorded')}, state {run.summary.get('state_hash', 'not known')}")]
    return rows


def travel(run):
    """Runout, drop and travel angle; where particles have no masses, they count alike."""
    try:
        from moraine.results import Run
        from moraine.runout import Runout, value_of
        there = Run(run.path)
        last = there.particles.read(-1)
        runout = Runout(there, 1.0, alike="mass" not in last.fields)
        values = {name: value_of(runout, name, last) for name in ("runout", "drop", "travel_angle")}
    except Exception:  # no particles, or no ground: the page has it not
        return []
    kind = {"path": "along the path of the scene", "steepest": "along the steepest way from the release", "x": "along x"}[runout.way.kind]
    alike = ", particles counted alike (output.fields has no mass)" if runout.alike else ""
    return [("runout L", f"{values['runout']:.4g} m {kind}{alike}"), ("drop H", f"{values['drop']:.4g} m"),
            ("travel angle", f"{values['travel_angle']:.3g} degrees (H / L = {values['drop'] / values['runout']:.3g})" if values["runout"] > 0 else "not known")]


def masses(run):
    """Where the mass is: what came in is what is there and what left."""
    mass, lost = run.history.get("mass_kg", []), run.history.get("lost_mass_kg", [])
    if not len(mass) or not len(lost):
        return []
    there, gone = float(mass[-1]), float(lost[-1])
    inside = there + gone
    share = f" ({100 * gone / inside:.2g} %)" if inside > 0 else ""
    return [("mass that came in", f"{inside / 1e3:.5g} t"), ("in the domain at the end", f"{there / 1e3:.5g} t"), ("left the domain", f"{gone / 1e3:.3g} t{share}")]


def places(run, scene):
    """Tables of gauges and sections."""
    from runs import table
    parts = []
    gauges = scene["hazard"].get("gauges", [])
    if gauges and (run.path / "gauges.csv").is_file():
        found, rows = table(run.path / "gauges.csv"), []
        for gauge in gauges:
            depth, speed, pressure = (list(found[f"{gauge['name']}_{column}"]) for column in ("depth_m", "speed_m_s", "pressure_Pa"))
            deepest = max(range(len(depth)), key=depth.__getitem__)
            came = next((t for t, d in zip(found["time_s"], depth) if d >= scene["hazard"]["threshold"]), None)
            rows.append((gauge["name"], ", ".join(f"{x:.10g}" for x in gauge["place"]), f"{depth[deepest]:.3g}", "never" if came is None else f"{came:.3g}",
                         f"{max(speed):.3g}", f"{max(pressure) / 1e3:.3g}", f"{depth[-1]:.3g}"))
        parts.append(page.table(("gauge", "x, y [m]", "deepest [m]", "arrival [s]", "fastest [m/s]", "pressure [kPa]", "depth at the end [m]"), rows))
    sections = scene["hazard"].get("sections", [])
    if sections and (run.path / "sections.csv").is_file():
        found, rows = table(run.path / "sections.csv"), []
        for section in sections:
            name = section["name"]
            rows.append((name, f"{max(found[name + '_discharge_m3_s']):.4g}", f"{found[name + '_volume_m3'][-1]:.5g}", f"{found[name + '_mass_kg'][-1] / 1e3:.5g}"))
        parts.append(page.table(("section", "largest discharge [m3/s]", "volume that passed [m3]", "mass [t]"), rows))
    return "".join(parts)


def with_bar(estimate, levels):
    """The finest value with the digits that its error, or its change to the level before, leaves."""
    from moraine.number_text import digits, exact, two_digits
    if estimate["error"]:
        return f"{digits(estimate['finest'], estimate['error'])} +- {two_digits(estimate['error'])}"
    before, now = ([level["values"][estimate["quantity"]] for level in levels[-2:]] * 2)[:2]
    return f"{exact(now, now - before, estimate['origin'])} (no bar is seen; {two_digits(abs(now - before))} from the level before)"


def bars(folder):
    """The error bars of a refinement study or a study of scenarios in `folder`, as a table."""
    from moraine.number_text import two_digits
    from wrong import Wrong
    path = pathlib.Path(folder)
    try:
        if (path / "converge.json").is_file():
            known = json.loads((path / "converge.json").read_text(encoding="utf-8"))
            levels = {variant["name"]: variant["levels"] for variant in known["variants"]}
            rows = [(e["quantity"], with_bar(e, levels[e["variant"]]), "-" if e["relative"] is None else f"{100 * e['relative']:.2g} %",
                     "not yet" if e["confirmed"] is None else "yes" if e["confirmed"] else "NO") for e in known["estimates"]]
            for variant in known["variants"]:
                rows += [(f"maps.{m['name']}, mean over its cells", "no bar is seen" if m["mean_error"] is None else f"+- {two_digits(m['mean_error'])}", "-",
                          f"outlines overlap by {100 * m['overlap']:.3g} %") for m in variant.get("maps", [])]
            return page.table(("quantity", "finest cells, error of the cells", "share", "confirmed by a further level"), rows)
        raise OSError("there is no converge.json in it")
    except (OSError, ValueError, LookupError, TypeError) as error:
        raise Wrong(f"--errors {folder} cannot be read ({error}). Is it the directory that moraine converge wrote?") from None


def facts(rows):
    return '<div class="scroll"><table class="words"><tbody>' + "".join(f"<tr><td>{html.escape(a)}</td><td style=\"text-align:left\">{html.escape(b)}</td></tr>"
                                                                         for a, b in rows) + "</tbody></table></div>"


def section(run, errors):
    """The first page as a section, empty where a run has no hazard maps; and why maps are missing."""
    scene = scene_of(run)
    if scene is None:
        return "", ""
    import flow
    shown, missing = "", ""
    try:
        import hazards
        shown = hazards.maps(run.path)
    except ImportError as lacking:
        missing = f"Hazard maps: {lacking}. Install them by <code>sudo apt-get install python3-matplotlib</code>."
    except Exception as wrong:  # a record that cannot be drawn costs its pictures, and not the page
        missing = f"Hazard maps of {html.escape(run.name)}: {html.escape(str(wrong) or type(wrong).__name__)}"
    known = bars(errors) if errors else "<p>Not known: one run on one size of cells. <code>moraine converge</code> of this scene tells, and <code>--errors</code> puts it here.</p>"
    parts = [flow.warnings(run), "<h3>What was asked</h3>", facts(asked(run, scene)), shown, "<h3>Places and lines</h3>" if scene["hazard"].get("gauges") or
             scene["hazard"].get("sections") else "", places(run, scene), "<h3>How far, and where the mass is</h3>", facts(travel(run) + masses(run)),
             "<h3>How sure it is</h3>", known, "<h3>Limits</h3><ul>" + "".join(f"<li>{html.escape(line)}</li>" for line in LIMITS) + "</ul>"]
    return f"<section>\n<h2>{html.escape(run.summary.get('title') or run.name)}: results</h2>\n{''.join(parts)}\n</section>", missing
