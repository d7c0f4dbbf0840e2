"""moraine replay: what recorded loads would cost on other ranks, and what it refuses."""
import csv
import re
import shutil

import moraine
from moraine import INPUTS, call, sets, summary, table

SCENE = INPUTS / "slurry_runout.toml"
END = 0.1 if moraine.SLOW else 0.4


class Replay(moraine.ProgramTest):
    def setUp(self):
        super().setUp()
        keys = sets(time__end=END, balance__interval=10, output__block_loads="on")
        self.run = self.run_scene(SCENE, "run", *keys, ranks=2)

    def replay(self, *words, code=0):
        ended = call("replay", self.run, *words)
        self.assertEqual(ended.code, code, ended)
        return ended

    def rows(self):
        with open(self.run / "replay.csv", newline="") as file:
            return list(csv.DictReader(file))

    def refused(self, *words):
        return self.assert_one_problem(call("replay", *words))

    def test_the_run_itself_is_predicted(self):
        self.replay("--ranks", "2", "--partitioner", "morton")
        measured, predicted = self.rows()
        self.assertEqual((measured["kind"], predicted["kind"]), ("measured", "predicted"))
        found, checks = summary(self.run), table(self.run, "balance.csv")
        self.assertAlmostEqual(float(predicted["imbalance_mean"]), found["imbalance_mean"], delta=0.01)
        sent = sum(row["halo_bytes"] for row in checks)
        self.assertAlmostEqual(float(predicted["halo_bytes"]), sent, delta=0.02 * sent)
        self.assertAlmostEqual(float(predicted["time_s"]), float(measured["time_s"]),
                               delta=0.15 * float(measured["time_s"]))

    def test_every_partitioner_is_predicted_and_said_to_be(self):
        said = self.replay("--ranks", "4,64", "--partitioner", "morton,slabs,rcb,metis", "--trigger", "never,every")
        self.assertIn("All lines but `measured` are predictions", said.out)
        self.assertRegex(said.out, r"can feed \d+ ranks at its start")
        rows = [row for row in self.rows() if row["kind"] == "predicted"]
        self.assertEqual(len(rows), 2 * (3 * 2 + 1))  # slabs are static: one line
        by_name = {(int(row["ranks"]), row["partitioner"], row["trigger"]): row for row in rows}
        self.assertEqual(by_name[64, "slabs", "static"]["repartitions"], "0")
        for p in (4, 64):
            exact = float(by_name[p, "morton", "every"]["imbalance_mean"])
            self.assertTrue(1 <= exact < float(by_name[p, "slabs", "static"]["imbalance_mean"]))

    def test_the_times_of_other_runs_can_count(self):
        other = self.run_scene(SCENE, "other", *sets(time__end=END, balance__interval=10, output__block_loads="on"))
        own = self.replay("--ranks", "4", "--partitioner", "morton").out
        both = self.replay("--ranks", "4", "--partitioner", "morton", "--calibrate", other).out
        self.assertNotEqual(own.split("\n")[1:3], both.split("\n")[1:3])
        single = self.run_scene(SCENE, "single", *sets(time__end=END, balance__interval=10, output__block_loads="on",
                                                       numerics__precision="single"))
        self.assertIn("Leave it out?", self.refused(self.run, "--calibrate", single))
        self.assertIn("no such directory", self.refused(self.run, "--calibrate", self.folder / "nowhere"))

    def test_what_a_scene_feeds_is_said_of_the_looks_that_are_replayed(self):
        moving = sets(body__block__velocity="[10.0, 0.0]", balance__interval=1, output__block_loads="on")
        self.run = self.run_scene(self.write(moraine.SMALL_SCENE), "moving", *moving)
        steps = int(table(self.run, "balance.csv")[-1]["step"])

        def fed(last, every):
            said = self.replay("--ranks", "1", "--partitioner", "morton", "--refine", "2", "--last-step", last,
                               "--every", every).out
            return [int(n) for n in re.search(r"can feed (\d+) ranks at its start and (\d+) at its w", said).groups()]

        start, worst = fed(steps, 1)
        self.assertLess(worst, start)
        self.assertEqual(fed(steps, 1000), [start, start])  # the first imbalance check and the last
        first = next(step for step in range(1, steps) if fed(step, 1)[1] == worst)
        self.assertEqual(fed(first, 1000), [start, worst])

    def test_no_trigger_beats_the_offline_optimum(self):
        self.replay("--ranks", "16", "--partitioner", "morton", "--regret", "--latency", "1e-6", "--bandwidth", "1e9")
        regrets = {row["trigger"]: float(row["regret_percent"]) for row in self.rows() if row["kind"] == "regret"}
        self.assertEqual(set(regrets), {"optimum", "never", "every", "threshold", "planned"})
        self.assertTrue(min(regrets.values()) >= -0.1 and regrets["optimum"] == 0, regrets)  # ties: optimum.hpp

    def test_hosts_have_a_network_between_and_one_within(self):
        def rows(*words):
            said = self.replay("--ranks", "8", "--partitioner", "morton,shuffle", "--trigger", "every", *words).out
            return said, {row["partitioner"]: row for row in self.rows() if row["kind"] == "predicted"}

        said, one = rows()
        self.assertNotIn("Hosts of", said)
        _, alike = rows("--ranks-per-host", "4")
        said, fast = rows("--ranks-per-host", "4", "--latency-within", "0", "--bandwidth-within", "1e15")
        self.assertIn("Hosts of 4 ranks in a row", said)
        for name in ("morton", "shuffle"):
            self.assertEqual(float(one[name]["halo_tiles_between_hosts"]), 0)
            self.assertEqual(alike[name]["halo_tiles_between_hosts"], fast[name]["halo_tiles_between_hosts"])
            self.assertEqual(alike[name]["halo_tiles"], one[name]["halo_tiles"])
            self.assertAlmostEqual(float(alike[name]["sending_s"]), float(one[name]["sending_s"]), delta=1e-9)
            self.assertLess(float(fast[name]["sending_s"]), float(alike[name]["sending_s"]))
        crossing = {name: float(row["halo_tiles_between_hosts"]) / float(row["halo_tiles"])
                    for name, row in fast.items()}
        self.assertLess(2 * crossing["morton"], crossing["shuffle"])

    def test_hosts_of_wrong_words_are_refused(self):
        self.assertIn("must be at least 1", self.refused(self.run, "--ranks-per-host", "0"))
        for option in ("--latency-within", "--bandwidth-within"):
            self.assertIn("there are no hosts", self.refused(self.run, option, "1"))
            for bad in ("-1", "nan", "inf"):
                self.assertIn("must be", self.refused(self.run, "--ranks-per-host", "2", f"{option}={bad}"))
        self.assertIn("above 0", self.refused(self.run, "--ranks-per-host", "2", "--bandwidth-within", "0"))

    def test_wrong_use_is_refused(self):
        self.assertIn("no such directory", self.refused(self.folder / "nowhere"))
        self.assertIn("output.block_loads=on", self.refused(self.folder))
        self.assertIn('"0" is not a number of ranks', self.refused(self.run, "--ranks", "4,0"))
        for empty in ("", "4,", "4,,16"):
            self.assertIn("nothing stands where a word should", self.refused(self.run, "--ranks", empty))
        for option in ("--partitioner", "--trigger", "--calibrate"):
            self.assertIn("nothing stands where a word should", self.refused(self.run, option, ""))
        self.assertIn("A larger --last-step?", self.refused(self.run, "--last-step", "5"))
        self.assertIn("a rank needs a block", self.refused(self.run, "--ranks", "4000000"))
        self.assertIn("Did you mean morton?", self.refused(self.run, "--partitioner", "mortn"))
        self.assertIn("Did you mean --ranks?", self.refused(self.run, "--rank", "4"))
        self.assertFalse((self.run / "replay.csv").exists())

    def test_a_truncated_record_is_refused_and_its_whole_part_can_be_used(self):
        whole = (self.run / "block_loads.bin").read_bytes()
        (self.run / "block_loads.bin").write_bytes(whole[:-100])
        words = self.refused(self.run)
        self.assertRegex(words, r"is truncated or damaged \(the interval of step \d+ is cut off\)")
        self.replay("--ranks", "4", *words.split(", ")[-1].rstrip("?").split())
        frame = (len(whole) - 168) // (len(table(self.run, "balance.csv")) + 1)
        (self.run / "block_loads.bin").write_bytes(whole[:168 + 64 + 64])
        self.assertIn("is truncated or damaged", self.refused(self.run))
        (self.run / "block_loads.bin").write_bytes(whole[:168])
        self.assertIn("holds 0 imbalance checks (a replay needs two). Run it for longer", self.refused(self.run))
        self.assertGreater(frame, 1000)

    def test_missing_intervals_are_told_by_the_table_of_the_run(self):
        rows = (self.run / "balance.csv").read_text().splitlines()
        extra = rows[-1].split(",")
        extra[0] = str(int(extra[0]) + 10)
        (self.run / "balance.csv").write_text("\n".join([*rows, ",".join(extra)]) + "\n")
        self.assertIn("is truncated (it ends at step", self.refused(self.run))

    def test_a_restart_goes_on_with_the_record(self):
        keys = sets(balance__interval=10, output__block_loads="on", output__checkpoint_interval=END / 2)
        first = self.run_scene(SCENE, "first", *keys, *sets(time__end=END), ranks=2)
        before = (first / "block_loads.bin").read_bytes()
        point = moraine.checkpoints(first)[0]
        self.run_scene(SCENE, "first", "--restart", point, *keys, *sets(time__end=END), ranks=3)
        self.assertGreater(len((first / "block_loads.bin").read_bytes()), len(before) // 2)
        steps = [row["step"] for row in table(first, "balance.csv")]
        self.assertEqual(steps, sorted(set(steps)))
        shutil.rmtree(self.run)
        first.rename(self.run)
        self.replay("--ranks", "4", "--partitioner", "morton")


if __name__ == "__main__":
    moraine.main()
