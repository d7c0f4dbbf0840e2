"""Whatever a file holds, the program refuses it in one line or does as it says; it never crashes, hangs or half begins.

As a test: a fixed list of cases, the same each time. By hand:
    python3 tests/program/test_fuzz.py --long HOURS [--seed N]     # others, until the time is over
    python3 tests/program/test_fuzz.py --case scene:17             # one again
What was found goes to CORPUS below, as few bytes as show it.
"""
import collections
import concurrent.futures
import sys
import tempfile
import time

import fuzz
import moraine

COUNTS = {"scene": 50, "run": 12, "checkpoint": 10, "forged": 20, "series": 8, "csv": 6, "loads": 8, "summary": 6, "table": 10, "hdf5": 24,
          "grid": 16, "gis": 24, "kill": 4, "rows": 12, "strength": 8, "staged": 16, "stagekill": 4}

# What once crashed, hung or ended with another code than 2, as the text of a scene.
CORPUS = {
    "keys of 50 000 levels": "[" + ".".join(["a"] * 50000) + "]",
    "a dotted key of 50 000 levels": ".".join(["a"] * 50000) + " = 1",
    "nested lists": "a = " + "[" * 40000,
    "a key of a million letters": "x" * 1000000 + " = 1",
    "a key with NUL": '"material\\u0000x" = 1',
    "an escape in a name": '[[material]]\nname = "\\u001b[31m"\n',
    "a name of two lines": '[[material]]\nname = "a\\nb"\n',
    "no text": "",
    "a byte order mark and no more": "\ufeff",
}


def cases_of_the_test():
    return [f"{kind}:{number}" for kind, count in COUNTS.items() for number in range(count)]


def tried(fuzzer, words):
    """(word, finding) of each case, two at a time."""
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        yield from zip(words, pool.map(fuzzer.case, words))


class Fuzz(moraine.ProgramTest):
    def test_no_damage_is_answered_otherwise_than_by_words(self):
        for word, finding in tried(fuzz.Fuzzer(self.folder), cases_of_the_test()):
            with self.subTest(word):
                self.assertIsNone(finding)

    def test_what_was_found_once_is_refused_at_once(self):
        fuzzer = fuzz.Fuzzer(self.folder)
        for name, text in CORPUS.items():
            (self.folder / "found.toml").write_text(text)
            with self.subTest(name):
                self.assertEqual(fuzzer.ask(["check", "found.toml"], self.folder, (2,)), (2, None))


def by_hand(words):
    with tempfile.TemporaryDirectory(prefix="moraine-") as folder:
        fuzzer = fuzz.Fuzzer(folder)
        if words[0] == "--case":
            print(fuzzer.case(words[1]) or "nothing found")
            return
        end = time.time() + 3600 * float(words[1])
        first = 1000000 * int(words[words.index("--seed") + 1]) if "--seed" in words else 1000000
        tries, found = collections.Counter(), collections.Counter()
        while time.time() < end:
            for word, finding in tried(fuzzer, [f"{kind}:{first}" for kind in fuzz.KINDS]):
                tries[word.split(":")[0]] += 1
                if finding:
                    found[word.split(":")[0]] += 1
                    print(f"{word}: {finding}", flush=True)
            first += 1
        for kind in fuzz.KINDS:
            print(f"{kind}: {tries[kind]} tried, {found[kind]} wrong")


if __name__ == "__main__":
    if len(sys.argv) > 2 and sys.argv[1] in ("--long", "--case"):
        moraine.allow_root()
        by_hand(sys.argv[1:])
    else:
        moraine.main()
