"""Stress tests that benchmarks/accuracy has measured already: S5 and S6 (update order, drift) and S11 (single precision), as lines of their own."""
import records

WORDS = {
    "S5": "energy and frequency of a ringing bar after 10 periods at 64 cells, at rest and adrift at Mach 0.05 (E1 of benchmarks/accuracy); goal: energy within 1 %",
    "S11": "errors in single and in double precision, all levels of benchmarks/accuracy; goal: within 0.1 % of the quantity",
}


def energy(lines):
    def norms(case, name):
        found = [x for x in lines if (x["case"], x["configuration"], x["precision"], x["cells"]) == (case, name, "double", 64) and "norms" in x]
        return found[0]["norms"] if found else {}
    for name in dict.fromkeys(x["configuration"] for x in lines if x["case"] == "E1"):
        rest, drift = norms("E1", name), norms("E1-drift", name)
        numbers = {"energy at rest": rest.get("energy"), "energy adrift": drift.get("energy"),
                   "frequency at rest": rest.get("frequency"), "frequency adrift": drift.get("frequency")}
        lost = [abs(numbers[k]) for k in ("energy at rest", "energy adrift") if numbers[k] is not None]
        yield line("S5", name, numbers, len(lost) == 2 and max(lost) <= 0.01, lines)


def precision(lines):
    for case in dict.fromkeys(x["case"] for x in lines):
        double = {(x["configuration"], x["cells"]): x for x in lines if x["case"] == case and x["precision"] == "double" and x.get("error") is not None}
        apart = [(abs(x["error"] - double[x["configuration"], x["cells"]]["error"]), x) for x in lines
                 if x["case"] == case and x["precision"] == "single" and x.get("error") is not None and (x["configuration"], x["cells"]) in double]
        if not apart:
            continue
        worst, at = max(apart, key=lambda pair: pair[0])
        within = sum(1 for a, _ in apart if a <= 1e-3)
        yield line("S11", case, {"levels": len(apart), "within": within, "worst": worst}, within == len(apart), lines, f"worst: {at['configuration']}, {at['cells']} cells")


def line(case, configuration, numbers, met, source, why=""):
    about = {k: source[0][k] for k in ("commit", "machine", "cores", "compiler", "march")}
    return {"case": case, "configuration": configuration, "numbers": numbers, "pass": met, "why": why, "seconds": 0, **about}


def lines(path):
    source = records.read(path)
    return list(energy(source)) + list(precision(source))
