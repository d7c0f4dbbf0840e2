"""Compares what is measured with scripts/budgets.toml: see scripts/check-budgets."""
import argparse
import pathlib
import re
import sys
import tomllib

import measures

STALE = 1.1  # an exception may be this much above what is measured; then it has to be lowered


def plain(value):
    return f"{value:g}" if isinstance(value, float) and abs(value) < 1e5 else str(value)


def judged(name, budget, found):
    """Sentences about what is wrong with one budget."""
    ceiling, over = budget["ceiling"], budget.get("over", {})
    for item, value in sorted(found.items(), key=lambda x: -x[1]):
        most = over.get(item, ceiling)
        if value > most:
            yield f"{item}: {plain(value)} {name} (the ceiling is {plain(most)}{'' if most == ceiling else f', to become {plain(ceiling)}'}). Less of it, or a part of its own?"
    for item, most in over.items():
        if not found:
            return  # no build, or nothing of the kind
        if item not in found:
            yield f"{item} is not there (it may have {plain(most)} {name} by scripts/budgets.toml). Take its line out by scripts/check-budgets --lower?"
        elif most <= ceiling:
            yield f"{item}: {plain(most)} is not over {plain(ceiling)} {name}. Take its line out by scripts/check-budgets --lower?"
        elif not budget.get("partial") and found[item] <= ceiling:
            yield f"{item}: {plain(found[item])} {name} are within the ceiling of {plain(ceiling)}. Take its line out by scripts/check-budgets --lower?"
        elif not budget.get("partial") and most > STALE * found[item]:
            yield f"{item}: {plain(found[item])} {name}, and {plain(most)} are allowed. Lower that by scripts/check-budgets --lower?"


def lowered(text, found):
    """The file with the exceptions that have fallen; nothing rises."""
    name, ceilings, kept = "", {}, []
    for line in text.splitlines(keepends=True):
        if header := re.match(r'\["([^"]+)"', line):
            name = header[1]
        elif value := re.match(r"ceiling = ([\d.]+)", line):
            ceilings[name] = float(value[1])
        elif (item := re.match(r'"([^"]+)" = ([\d.]+)$', line)) and found.get(name):
            now = found[name].get(item[1], 0)
            if now <= ceilings[name]:
                continue
            if now < float(item[2]):
                line = f'"{item[1]}" = {plain(now)}\n'
        kept.append(line)
    return "".join(kept)


def main():
    parser = argparse.ArgumentParser(prog="check-budgets", description=__doc__)
    parser.add_argument("--root", type=pathlib.Path, default=pathlib.Path(__file__).resolve().parents[2])
    parser.add_argument("--build", type=pathlib.Path)
    parser.add_argument("--lower", action="store_true")
    parser.add_argument("--list", action="store_true")
    given = parser.parse_args()
    file = given.root / "scripts/budgets.toml"
    budgets = tomllib.loads(file.read_text())
    if unknown := set(budgets) ^ set(measures.BUDGETS):
        sys.exit(f"check-budgets: {', '.join(sorted(unknown))} (counted or budgeted, not both). Which name is wrong?")
    found = measures.measure(given.root, given.build or given.root / "build/release")
    if given.lower:
        file.write_text(lowered(file.read_text(), found))
        budgets = tomllib.loads(file.read_text())
    if given.list:
        for name, items in found.items():
            for item, value in sorted(items.items(), key=lambda x: -x[1]):
                print(f"{name}\t{plain(value)}\t{item}")
    wrong = [sentence for name, budget in budgets.items() for sentence in judged(name, budget, found[name])]
    for sentence in wrong:
        print(sentence, file=sys.stderr)
    unseen = [name for name, items in found.items() if not items]
    print(f"check-budgets: {len(wrong)} over or stale" + (f" (nothing to count for: {', '.join(unseen)})" if unseen else ""), file=sys.stderr)
    return 1 if wrong else 0


sys.exit(main())
