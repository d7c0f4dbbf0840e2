"""moraine replay: what recorded loads would cost on other ranks, and what it refuses."""
import csv
import re
import shutil
import struct

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

    def test_intervals_that_are_too_long_for_finer_cells_and_the_refinement_that_ranks_want_are_said(self):
        moving = sets(body__block__velocity="[10.0, 0.0]", output__block_loads="on")
        self.run = self.run_scene(self.write(moraine.SMALL_SCENE), "moving", *moving, *sets(balance__interval=8))
        told = self.replay("--ranks", "4", "--partitioner", "morton", "--refine", "4").out
        crosses, wanted = re.search(r"the flow crosses ([\d.]+) blocks of this grid .* balance\.interval = (\d+)\?", told).groups()
        self.assertAlmostEqual(8 / float(crosses), int(wanted), delta=1 + 0.05 * int(wanted))
        self.assertNotIn("Warning", self.replay("--ranks", "1", "--partitioner", "morton").out)
        most, more = re.search(r"At most (\d+), or --refine (\d+)\?", self.refused(self.run, "--ranks", "20000")).groups()
        self.assertTrue(int(most) * 4**(int(more) - 1) < 20000 <= int(most) * 4**int(more))
        self.assertRegex(self.replay("--ranks", "300", "--partitioner", "morton", "--refine", "4").out, r"300 ranks want --refine \d: cells \d+ times smaller|can feed")

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
        frame = (len(whole) - 176) // (len(table(self.run, "balance.csv")) + 1)
        (self.run / "block_loads.bin").write_bytes(whole[:176 + 64 + 64])
        self.assertIn("is truncated or damaged", self.refused(self.run))
        (self.run / "block_loads.bin").write_bytes(whole[:176])
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


BED = INPUTS / "undercut_bed.toml"
COARSE = dict(domain__cell=0.008, time__end=0.2, balance__interval=20, output__block_loads="sleep")


def sleepers(run):
    """Of each imbalance check its step, who is there, and who sleeps, by key."""
    data, at, checks = (run / "block_loads.bin").read_bytes(), 176, []
    while at < len(data):
        _, step, _, _, _, ranks, blocks, _ = struct.unpack_from("<8sqddqqqQ", data, at)
        at += 64 + 32 * ranks
        rows = [struct.unpack_from("<QIi", data, at + 16 * b) for b in range(blocks)]
        at += 16 * blocks
        checks.append((step, {key: particles & 0x7fffffff for key, particles, _ in rows}, {key for key, particles, _ in rows if particles >> 31}))
    return checks


def awake_share(check):
    _, there, asleep = check
    return 1 - sum(there[key] for key in asleep) / sum(there.values())


class ReplayOfSleep(moraine.ProgramTest):
    def record(self, name, sleep, *words, ranks=1, **keys):
        return self.run_scene(BED, name, *words, *sets(**{**COARSE, **keys, "numerics__sleep": sleep}), ranks=ranks)

    def test_a_run_recorded_awake_predicts_the_one_that_sleeps(self):
        awake, asleep = self.record("awake", "off"), self.record("asleep", "on", ranks=2)
        would, slept = sleepers(awake), sleepers(asleep)
        self.assertEqual([check[0] for check in would], [check[0] for check in slept])
        shares = [(awake_share(a), awake_share(b)) for a, b in zip(would, slept)]
        self.assertLess(shares[-1][1], 0.4)  # it does sleep, and not from the first step on
        self.assertEqual(shares[0], (1, 1))
        self.assertLess(sum(abs(a - b) for a, b in shares) / len(shares), 0.03)
        ended = call("replay", awake, "--ranks", "2", "--partitioner", "morton", "--sleep")
        self.assertEqual(ended.code, 0, ended)
        self.assertRegex(ended.out, r"Of the particle-steps \d+\.\d % would have slept; 16 sleeping")
        with open(awake / "replay.csv", newline="") as file:
            predicted = list(csv.DictReader(file))[1]
        found = summary(asleep)
        self.assertAlmostEqual(float(predicted["asleep_share"]), found["sleep"]["share_of_particle_steps"], delta=0.03)
        self.assertAlmostEqual(float(predicted["imbalance_mean"]), found["imbalance_mean"], delta=0.03)
        self.assertAlmostEqual(float(predicted["imbalance_max"]), found["imbalance_max"], delta=0.1)
        self.assertGreater(found["imbalance_max"], 1.2)
        self.assertEqual(call("replay", awake, "--ranks", "2", "--partitioner", "morton").code, 0)
        with open(awake / "replay.csv", newline="") as file:
            without = list(csv.DictReader(file))[1]
        self.assertEqual(float(without["asleep_share"]), 0)
        self.assertLess(float(without["imbalance_max"]), 1.1)

    def test_near_a_structure_that_moves_nobody_would_sleep(self):
        hovers = '[[structure]]\nname = "hand"\nshape = "box"\nmin = [0.05, 0.06]\nmax = [0.1, 0.09]\nmotion = { kind = "velocity", velocity = [0.1, 0.0] }\n'
        scene = self.write(BED.read_text() + hovers)
        would, slept = (sleepers(self.run_scene(scene, sleep, *sets(**COARSE, numerics__sleep=sleep))) for sleep in ("off", "on"))
        shares = [(awake_share(a), awake_share(b)) for a, b in zip(would, slept)]
        self.assertGreater(shares[-1][1], 0.3)
        self.assertLess(shares[-1][1], 0.6)
        self.assertLess(sum(abs(a - b) for a, b in shares) / len(shares), 0.03)

    def test_who_would_sleep_is_the_same_on_any_ranks_and_changes_no_run(self):
        keys = dict(time__end=0.12, balance__trigger="every")
        alone = self.record("alone", "off", **keys)
        shared = self.record("shared", "off", "--partitioner", "shuffle", ranks=3, **keys)
        self.assertEqual(sleepers(shared), sleepers(alone))
        self.assertLess(awake_share(sleepers(alone)[-1]), 0.5)
        unrecorded = self.record("unrecorded", "off", **{**keys, "output__block_loads": "off"})
        self.assertEqual(summary(unrecorded)["state_hash"], summary(alone)["state_hash"])

    def test_a_run_that_slept_is_replayed_as_it_slept(self):
        asleep = self.record("asleep", "on")
        ended = call("replay", asleep, "--ranks", "1", "--partitioner", "morton")
        share = float(re.search(r"Of the particle-steps (\S+) % slept", ended.out).group(1)) / 100
        self.assertAlmostEqual(share, summary(asleep)["sleep"]["share_of_particle_steps"], delta=0.01)
        table_of = [(awake_share(check), row["awake"] / (row["awake"] + row["asleep"])) for check, row in zip(sleepers(asleep)[1:], table(asleep, "balance.csv"))]
        for recorded, told in table_of:
            self.assertAlmostEqual(recorded, told, delta=1e-9)

    def test_a_record_that_does_not_say_who_would_sleep_is_refused(self):
        plain = self.record("plain", "off", output__block_loads="on", time__end=0.01)
        said = self.assert_one_problem(call("replay", plain, "--sleep"))
        self.assertIn("--sleep of", said)
        self.assertIn("output.block_loads=sleep", said)
        self.assertEqual(call("replay", plain, "--ranks", "1").code, 0)

    def test_who_would_sleep_is_recorded_only_of_a_scene_that_can_sleep(self):
        keys = sets(output__block_loads="sleep", numerics__sleep="off", numerics__transfer="flip")
        said = self.assert_one_problem(call("check", BED, *keys))
        self.assertIn('output.block_loads = "sleep" with this numerics.transfer', said)


if __name__ == "__main__":
    moraine.main()
