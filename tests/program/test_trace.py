"""moraine run --trace: one file of all ranks that a viewer of Chrome's trace events opens, which changes no answer."""
import json
import os

import moraine
from moraine import INPUTS, call, sets, summary, table

SCENE = INPUTS / "slurry_runout.toml"
KEYS = sets(domain__cell=0.25, time__end=0.1, output__interval=0.05, output__checkpoint_interval=0.05, balance__interval=10, balance__trigger="every")
PHASES = ("p2g", "nodes", "g2p", "halo", "agree", "migrate", "balance", "output")


def spans_of(events, rank):
    return [event for event in events if event["ph"] == "X" and event["pid"] == rank]


class Trace(moraine.ProgramTest):
    def traced(self, ranks, *words):
        file = self.folder / "trace.json"
        directory = self.run_scene(SCENE, f"on-{ranks}", *KEYS, "--trace", file, *words, ranks=ranks)
        return directory, json.loads(file.read_text())

    def assert_nested(self, spans):
        """Each begins after the one before, and ends before all that it is in; times are whole nanoseconds."""
        begins = [round(1e3 * span["ts"]) for span in spans]
        self.assertEqual(begins, sorted(begins))
        open_ends = []
        for begin, span in zip(begins, spans):
            end = begin + round(1e3 * span["dur"])
            while open_ends and open_ends[-1] <= begin:
                open_ends.pop()
            if open_ends:
                self.assertLessEqual(end, open_ends[-1], span)
            open_ends.append(end)

    def test_each_rank_has_its_phases_in_order_and_what_rarely_happens(self):
        directory, trace = self.traced(3)
        self.assertEqual((trace["otherData"]["ranks"], trace["otherData"]["stride"], trace["otherData"]["lost"]), (3, 1, 0))
        names = [event["args"]["name"] for event in trace["traceEvents"] if event["name"] == "process_name"]
        self.assertEqual(names, ["rank 0 on cpu", "rank 1 on cpu", "rank 2 on cpu"])
        steps = summary(directory)["steps"]
        for rank in range(3):
            spans = spans_of(trace["traceEvents"], rank)
            self.assert_nested(spans)
            self.assertEqual({span["cat"] for span in spans}, {"run", *PHASES})
            self.assertEqual([span["args"]["step"] for span in spans if span["name"] == "step"], list(range(steps)))
            count = {name: sum(span["name"] == name for span in spans) for name in ("start", "G2P", "output", "checkpoint", "repartition")}
            self.assertEqual(count, {"start": 1, "G2P": steps, "output": 3, "checkpoint": 2, "repartition": summary(directory)["repartitions"]})
            step = next(span for span in spans if span["name"] == "step" and span["args"]["step"] == 3)
            inside = [span["name"] for span in spans if step["ts"] <= span["ts"] < step["ts"] + step["dur"]]
            self.assertEqual([name for name in inside if name not in ("substep", "send halo", "receive halo", "device leads")],
                             ["step", "bin", "P2G boundary", "take report", "P2G interior", "agree on dt", "solve nodes", "G2P", "send outgoing"])

    def test_its_seconds_are_those_of_the_records(self):
        directory, trace = self.traced(2)
        rows = table(directory, "balance.csv")
        last = 10 * (summary(directory)["steps"] // 10)
        for phase in ("p2g", "g2p", "nodes", "halo"):
            with self.subTest(phase):
                recorded = sum(row[f"{phase}_mean_s"] for row in rows)
                spans = [span for rank in range(2) for span in spans_of(trace["traceEvents"], rank) if span["cat"] == phase and span["args"]["step"] < last]
                self.assertAlmostEqual(sum(span["dur"] for span in spans) / 2e6, recorded, delta=1e-3 * recorded)

    def test_the_answer_is_that_without_it_and_on_one_rank_there_is_no_mpirun(self):
        plain = summary(self.run_scene(SCENE, "plain", *KEYS, ranks=None))
        directory, trace = self.traced(None)
        self.assertEqual(summary(directory)["state_hash"], plain["state_hash"])
        self.assertEqual({event["pid"] for event in trace["traceEvents"]}, {0})
        self.assert_nested(spans_of(trace["traceEvents"], 0))

    def test_a_run_that_ends_by_a_fault_leaves_its_timeline(self):
        file, scene = self.folder / "trace.json", self.write(moraine.SMALL_SCENE + '[[wall]]\nface = "x-max"\nkind = "free-slip"\n')
        ended = call("run", scene, "--output", self.folder / "fault", "--quiet", *sets(body__block__velocity="[0.0, 300.0]"), "--trace", file, ranks=2)
        self.assertEqual(ended.code, 3, ended)
        self.assertEqual({event["pid"] for event in json.loads(file.read_text())["traceEvents"]}, {0, 1})

    def test_what_cannot_be_written_is_refused_before_anything_is_run(self):
        (self.folder / "there.json").write_text("mine")
        scene = self.write(moraine.SMALL_SCENE)
        for name, words in (("there.json", "it is there"), (".", "it is a folder"), ("none/trace.json", "is no folder"), ("there.json/trace.json", "is no folder"),
                            ("/proc/trace.json", "no file can be made in /proc")):
            for ranks in (None, 2):
                with self.subTest(name, ranks=ranks):
                    ended = call("run", scene, "--output", self.folder / "refused", "--trace", self.folder / name, ranks=ranks)
                    self.assertIn(words, self.assert_one_problem(ended))
        self.assertFalse((self.folder / "refused").exists())
        self.assertEqual((self.folder / "there.json").read_text(), "mine")

    def test_it_may_lie_in_the_folder_of_the_run_and_is_replaced_with_it(self):
        scene, output = self.write(moraine.SMALL_SCENE), self.folder / "run"
        words = ("run", scene, "--output", output, "--quiet", "--trace", output / "trace.json")
        self.assertEqual(call(*words).code, 0)
        first = json.loads((output / "trace.json").read_text())
        self.assert_one_problem(call(*words))
        self.assertEqual(call(*words, "--overwrite").code, 0)
        self.assertEqual(len(json.loads((output / "trace.json").read_text())["traceEvents"]), len(first["traceEvents"]))
        self.assertEqual([name for name in os.listdir(output) if name.endswith(".partial")], [])


if __name__ == "__main__":
    moraine.main()
