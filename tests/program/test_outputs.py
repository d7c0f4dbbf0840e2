"""What a run writes: summary.json, history.csv, balance.csv, and how a restart goes on with them."""
import math
import os
import re
import resource
import shutil
import struct
import subprocess

import moraine
from moraine import INPUTS, SMALL_SCENE, call, checkpoints, sets, summary, table

SCENE = INPUTS / "slurry_runout.toml"
END = 0.05 if moraine.SLOW else 0.1
STEP = 0.006  # above the longest of the scene [s]
PHASES = ("p2g", "nodes", "g2p", "halo", "agree", "migrate", "balance", "output")

SUMMARY = {
    str: "version commit scene device precision partitioner state_hash",
    int: "ranks threads particles steps repartitions migrated_particles crossed_particles halo_bytes",
    float: "simulated_time_s wall_s particle_steps_per_s imbalance_mean imbalance_max imbalance_time_mean mass_kg "
           "front_m",
    list: "momentum",
    dict: "energies_J times_s",
}
HISTORY = """time_s dt_s mass_kg momentum_x_kg_m_s momentum_y_kg_m_s kinetic_J strain_J potential_J dissipated_J front_m
    centre_x_m centre_y_m max_speed_m_s min_J max_J"""
BALANCE = "step time_s particles_min particles_mean particles_max imbalance blocks halo_bytes migrated_particles " \
    "migrated_blocks repartitioned " + " ".join(f"{phase}_mean_s {phase}_max_s" for phase in PHASES)


class Outputs(moraine.ProgramTest):
    def run_slurry(self, *words, ranks=3, **keys):
        words += tuple(sets(**({"time__end": END, "output__interval": END / 5} | keys)))
        return self.run_scene(SCENE, f"out-{len(list(self.folder.iterdir()))}", *words, ranks=ranks)

    def test_summary_has_every_promised_key(self):
        found = summary(self.run_slurry())
        for kind, names in SUMMARY.items():
            for name in names.split():
                self.assertIsInstance(found[name], (int, float) if kind is float else kind, name)
        for name in ("kinetic", "strain", "potential", "dissipated"):
            self.assertTrue(math.isfinite(found["energies_J"][name]))
        self.assertEqual(len(found["momentum"]), 2)
        self.assertRegex(found["state_hash"], "^[0-9a-f]{16}$")
        self.assertRegex(found["version"], r"^\d+\.\d+\.\d+$")
        said = {"scene": "slurry_runout", "device": "cpu", "precision": "double", "ranks": 3, "threads": 1,
                "partitioner": "morton", "particles": 20000}
        self.assertEqual({key: found[key] for key in said}, said)

    def test_a_limit_on_the_size_of_files_is_said_and_what_was_written_stays(self):
        directory = self.folder / "limited"
        job = moraine.Job("run", SCENE, "--output", directory, "--quiet", *sets(time__end=60, output__interval=END / 5),
                          ranks=None)
        self.addCleanup(job.stop)
        job.wait_for(directory, "particles.vtkhdf")
        resource.prlimit(job.started.pid, resource.RLIMIT_FSIZE, (1000, 1000))
        line = self.assert_one_problem(job.end(), code=4)
        self.assertRegex(line, r"cannot write .* \(File too large\)\. .*ulimit -f")
        self.assertTrue((directory / "history.csv").exists())

    def test_numbers_of_a_summary_agree(self):
        found = summary(self.run_slurry())
        self.assertTrue(END <= found["simulated_time_s"] < END + STEP)
        self.assertAlmostEqual(found["mass_kg"], 10 * 5 * 1500.0, places=6)
        self.assertTrue(1 <= found["imbalance_mean"] <= found["imbalance_max"] * (1 + 1e-12) < 1.1, found)
        self.assertGreaterEqual(found["imbalance_time_mean"], 1)
        self.assertGreater(found["halo_bytes"], 1000 * found["steps"])
        self.assertTrue(10 <= found["front_m"] < 11)
        stepping = found["particles"] * found["steps"] / found["particle_steps_per_s"]
        self.assertTrue(0.1 * found["wall_s"] < stepping < found["wall_s"], found)

    def test_times_add_up_to_the_wall_time_and_are_said_at_the_end(self):
        directory = self.folder / "said"
        ended = call("run", SCENE, "--output", directory, *sets(time__end=END), ranks=2)
        self.assertEqual(ended.code, 0, ended)
        found = summary(directory)
        self.assertAlmostEqual(sum(found["times_s"].values()), found["wall_s"], delta=1e-9)
        self.assertTrue(all(seconds >= 0 for name, seconds in found["times_s"].items() if name != "rest"), found)
        percent = 100 * found["times_s"]["lost_to_imbalance"] / found["wall_s"]
        self.assertRegex(ended.err, f"lost to imbalance +{percent:.1f} %")
        self.assertRegex(ended.err, r"lost to balancing +\d+\.\d %  checks, plans, \d+ repartition")

    def test_a_run_without_particles_leaves_the_same_records_and_checkpoints(self):
        every = {"output__checkpoint_interval": END / 2}
        whole, without = self.run_slurry(**every), self.run_slurry("--no-particles", **every)
        self.assertTrue((whole / "particles.vtkhdf").exists())
        self.assertFalse((without / "particles.vtkhdf").exists())
        self.assertEqual(summary(whole)["state_hash"], summary(without)["state_hash"])
        self.assertEqual((whole / "history.csv").read_text(), (without / "history.csv").read_text())
        self.assertEqual([c.name for c in checkpoints(whole)], [c.name for c in checkpoints(without)])

    def test_block_loads_are_recorded_only_where_the_scene_asks_for_them(self):
        without = self.run_slurry(balance__interval=2)
        self.assertFalse((without / "block_loads.bin").exists())
        recorded = self.run_slurry(balance__interval=2, output__block_loads="on")
        self.assertEqual(summary(recorded)["state_hash"], summary(without)["state_hash"])
        data = (recorded / "block_loads.bin").read_bytes()
        rows, at, seen, lost = table(recorded, "balance.csv"), 176, [], 0
        while at < len(data):
            mark, step, _, loses, exchanges, ranks, blocks, _ = struct.unpack_from("<8sqddqqqQ", data, at)
            at += 64 + 32 * ranks
            loads = [struct.unpack_from("<QIi", data, at + 16 * b) for b in range(blocks)]
            at += 16 * blocks
            self.assertEqual((mark, ranks, sum(load[1] & 0x7fffffff for load in loads)), (b"interval", 3, 20000))
            self.assertEqual(sorted({load[2] for load in loads}), [0, 1, 2])
            steps = step - (seen[-1][0] if seen else 0)
            self.assertTrue(3 * steps <= exchanges <= 11 * steps, (step, exchanges))  # one, and one in each substep
            seen.append((step, blocks))
            lost += loses
        self.assertEqual(seen[1:], [(row["step"], row["blocks"]) for row in rows])
        self.assertEqual(seen[0][0], 0)
        in_all = summary(recorded)["times_s"]["lost_to_imbalance"]  # steps behind the last imbalance check included
        self.assertTrue(0.5 * in_all < lost <= 1.001 * in_all, (lost, in_all))

    def test_intervals_far_below_a_step_are_one_a_step(self):
        directory = self.run_scene(self.write(SMALL_SCENE), "each", *sets(output__interval=1e-300, time__end=0.01))
        self.assertEqual(len(table(directory, "history.csv")), summary(directory)["steps"] + 1)

    def test_history_keeps_mass_and_momentum(self):
        directory = self.run_slurry()
        rows, last = table(directory, "history.csv"), summary(directory)
        self.assertLessEqual(set(HISTORY.split()), set(rows[0]))
        self.assertEqual(len(rows), 6)
        unit = 75000 * math.sqrt(9.81 * 5)  # M v_ref
        for k, row in enumerate(rows):
            self.assertTrue(k * END / 5 <= row["time_s"] < k * END / 5 + STEP)
            self.assertEqual((row["mass_kg"], row["particles"], row["lost_particles"]), (75000, 20000, 0))
            for axis in "xy":
                self.assertLess(abs(row[f"momentum_error_{axis}_kg_m_s"]), 1e-12 * unit)
            self.assertTrue(0.9 < row["min_J"] <= 1 <= row["max_J"] < 1.1)
        self.assertLess(rows[-1]["centre_y_m"], rows[0]["centre_y_m"])
        self.assertGreater(rows[-1]["centre_x_m"], rows[0]["centre_x_m"])
        self.assertEqual((rows[-1]["step"], rows[-1]["time_s"]), (last["steps"], last["simulated_time_s"]))
        self.assertEqual([rows[-1][f"momentum_{a}_kg_m_s"] for a in "xy"], last["momentum"])
        self.assertEqual({e: rows[-1][f"{e}_J"] for e in last["energies_J"]}, last["energies_J"])
        self.assertEqual(rows[-1]["front_m"], last["front_m"])

    def test_energy_that_is_unaccounted_for_is_a_few_percent_of_what_the_fall_frees(self):
        # To 0.2 s: until then substeps damp the wave that runs in from the face that is free at once, 0.05 % of the energy.
        first, *_, last = table(self.run_slurry(time__end=0.2), "history.csv")
        freed = first["potential_J"] - last["potential_J"] + first["strain_J"]
        self.assertGreater(freed, 0)
        self.assertLess(abs(last["unaccounted_J"]), 0.05 * freed)

    def test_balance_rows_agree_with_each_other_and_the_summary(self):
        directory = self.run_slurry("--partitioner", "shuffle", balance__trigger="every", balance__interval=4)
        rows, last = table(directory, "balance.csv"), summary(directory)
        self.assertLessEqual(set(BALANCE.split()), set(rows[0]))
        self.assertEqual([row["step"] for row in rows], list(range(4, last["steps"] + 1, 4)))
        for row in rows:
            self.assertAlmostEqual(row["particles_mean"], 20000 / 3)
            self.assertTrue(0 < row["particles_min"] <= row["particles_mean"] <= row["particles_max"])
            self.assertAlmostEqual(row["imbalance"], row["particles_max"] / row["particles_mean"])
            self.assertGreaterEqual(row["imbalance"], 1)
            self.assertGreaterEqual(row["blocks"], 300)
            self.assertTrue(all(0 <= row[f"{p}_mean_s"] <= row[f"{p}_max_s"] * 1.000001 for p in PHASES), row)
        for column, key in (("migrated_particles", "migrated_particles"), ("repartitioned", "repartitions")):
            self.assertEqual(sum(row[column] for row in rows), last[key])
        self.assertEqual(last["repartitions"], last["steps"] // 4)
        self.assertLessEqual(sum(row["halo_bytes"] for row in rows), last["halo_bytes"])

    def test_balance_rows_say_what_was_planned_and_why(self):
        costs = ("keep_s", "natural_s", "relabelled_s", "least_migration_s")
        for row in table(self.run_slurry(balance__trigger="every", balance__interval=4), "balance.csv"):
            self.assertEqual(row["reason"], "every")
            self.assertIn(row["plan"], ("natural", "relabelled", "least migration"))
            self.assertTrue(math.isnan(row["keep_s"]))
            offered = [row[cost] for cost in costs[1:]]
            self.assertEqual(row[row["plan"].replace(" ", "_") + "_s"], min(offered))
            self.assertGreater(min(offered), 0)
        for row in table(self.run_slurry(balance__interval=4), "balance.csv"):
            self.assertEqual((row["reason"], row["plan"]), ("balanced", "none"))
            self.assertTrue(all(math.isnan(row[cost]) for cost in costs))
        for row in table(self.run_slurry("--partitioner", "slabs", balance__interval=4), "balance.csv"):
            self.assertEqual((row["reason"], row["plan"]), ("static", "none"))
        keys = sets(time__end=15 * END, output__interval=END, balance__trigger="planned", balance__interval=4)
        rows = table(self.run_scene(SCENE, "planned", *keys, ranks=3), "balance.csv")
        for row in rows:  # no plan before the growth of the loss has cost what the smallest migration takes
            self.assertIn(row["reason"], ("no better plan", "not worth it", "cheaper to keep", "planned"))
            if row["plan"] == "none":
                self.assertEqual(row["reason"], "not worth it")
                self.assertTrue(all(math.isnan(row[cost]) for cost in costs), row)
            else:
                self.assertTrue(all(row[cost] > 0 for cost in costs), row)
        self.assertTrue(moraine.SLOW or any(row["plan"] != "none" for row in rows))

    def test_the_morton_cut_is_even_to_within_a_block_at_the_start_and_after_a_repartition(self):
        directory = self.run_slurry(balance__trigger="every", balance__interval=4)
        block = 16 * 4  # particles
        for row in table(directory, "balance.csv"):
            self.assertLessEqual(row["particles_max"], row["particles_mean"] + block)
            self.assertGreaterEqual(row["planned_imbalance"], 1)
        self.assertLessEqual(summary(directory)["imbalance_max"], 1 + block * 3 / 20000)

    def test_slabs_say_once_that_they_ignore_the_trigger_and_are_far_from_balanced(self):
        ended = call("run", SCENE, "--output", self.folder / "slabs", *sets(time__end=END / 5),
                     "--partitioner", "slabs", ranks=2)
        self.assertEqual(ended.code, 0, ended)
        self.assertEqual(len(re.findall("balance.trigger", ended.err)), 1, ended)
        found = summary(self.folder / "slabs")
        self.assertEqual((found["partitioner"], found["imbalance_mean"], found["repartitions"]), ("slabs", 2, 0))

    def test_progress_is_plain_lines_in_a_log_and_nothing_when_quiet(self):
        scene = self.write(SMALL_SCENE)
        ended = call("run", scene, "--output", self.folder / "loud", ranks=2)
        self.assertEqual((ended.code, ended.out), (0, ""))
        self.assertNotIn("\r", ended.err)
        for word in ("step", "ETA", "particle-steps/s", "imbalance", str(self.folder / "loud")):
            self.assertIn(word, ended.err)
        ended = call("run", scene, "--output", self.folder / "quiet", "--quiet", ranks=2)
        self.assertEqual((ended.code, ended.out, ended.err), (0, "", ""))

    def test_the_default_directory_is_named_after_the_scene(self):
        scene = self.write(SMALL_SCENE, "jelly.toml")
        self.assertEqual(call("run", scene, "--quiet", folder=self.folder).code, 0)
        self.assertEqual(summary(self.folder / "runs" / "jelly")["scene"], "jelly")

    def test_a_restart_continues_the_records_of_its_directory_and_starts_those_of_a_new_one(self):
        directory = self.run_slurry(output__checkpoint_interval=0.4 * END, balance__interval=4)
        whole, hash_ = table(directory, "history.csv"), summary(directory)["state_hash"]
        rows = table(directory, "balance.csv")
        first = checkpoints(directory)[0]
        at = int(first.name[11:20])
        words = ("--restart", first)
        fresh = self.run_slurry(*words, ranks=2, balance__interval=4)
        self.run_scene(SCENE, directory.name, *sets(time__end=END, output__interval=END / 5, balance__interval=4),
                       *words, ranks=2)
        self.assertEqual(table(directory, "history.csv"), whole)
        self.assertEqual(table(fresh, "history.csv"), [row for row in whole if row["step"] > at])
        self.assertEqual([r["step"] for r in table(directory, "balance.csv")], [r["step"] for r in rows])
        self.assertEqual([r["step"] for r in table(fresh, "balance.csv")], [r["step"] for r in rows if r["step"] > at])
        self.assertEqual({summary(d)["state_hash"] for d in (directory, fresh)}, {hash_})
        self.assertEqual({summary(d)["steps"] for d in (directory, fresh)}, {whole[-1]["step"]})

    def test_a_restart_with_numbers_of_another_size_is_refused_and_leaves_all_as_it_was(self):
        directory = self.run_slurry(output__checkpoint_interval=0.4 * END)
        before = {path.name: path.read_bytes() for path in directory.iterdir()}
        ended = call("run", SCENE, "--output", directory, "--quiet", "--restart", checkpoints(directory)[0],
                     *sets(output__precision="single"), ranks=2)
        self.assertIn("output.precision", self.assert_one_problem(ended))
        self.assertEqual({path.name: path.read_bytes() for path in directory.iterdir()}, before)

    def test_a_history_of_another_run_is_not_continued(self):
        directory = self.run_slurry(output__checkpoint_interval=0.4 * END)
        other = self.run_slurry(material__slurry__viscosity=60)
        shutil.copy(other / "history.csv", directory)
        ended = call("run", SCENE, "--output", directory, "--quiet", "--restart", checkpoints(directory)[0])
        self.assertIn("history.csv (it lacks the row", self.assert_one_problem(ended))
        self.assertEqual((directory / "history.csv").read_text(), (other / "history.csv").read_text())

    def test_the_cores_of_ranks_that_are_bound_to_their_own_are_counted_together(self):
        cores = sorted(os.sched_getaffinity(0))[:2]
        scene, directory = self.write(SMALL_SCENE), self.folder / "bound"
        words = moraine.command(["run", scene, "--output", directory, "--quiet"], ranks=1)
        at = words.index(moraine.PROGRAM)
        ranks = [[*words[at - 2:at], "taskset", "-c", str(core), *words[at:]] for core in cores]
        parts = [part for rank in ranks for part in (":", *rank)][1:]
        done = subprocess.run([*words[:at - 2], *parts], env=moraine.environment(), capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done)
        self.assertEqual(summary(directory)["ranks"], len(cores))
        self.assertRegex(summary(directory)["machine"], rf", {len(cores)} cores?$")


if __name__ == "__main__":
    moraine.main()
