"""Ranks of several hosts, pretended on one machine: the same answer, what crosses hosts is counted, and neighbours
along the curve are on one host."""
import os
import re

import moraine
from moraine import INPUTS, sets, summary, table

SCENE = INPUTS / "slurry_runout.toml"
KEYS = sets(time__end=0.1 if moraine.SLOW else 0.4, balance__interval=10)


class PretendedHosts(moraine.ProgramTest):
    def tearDown(self):
        os.environ.pop("MORAINE_PRETEND_HOSTS", None)
        os.environ.pop("MORAINE_PRETEND_MEMORY", None)
        super().tearDown()

    def run_on(self, hosts, *words, ranks=4):
        if hosts:
            os.environ["MORAINE_PRETEND_HOSTS"] = str(hosts)
        name = f"hosts-{hosts}-{ranks}-{len(list(self.folder.iterdir()))}"
        directory = self.run_scene(SCENE, name, *KEYS, *words, ranks=ranks)
        os.environ.pop("MORAINE_PRETEND_HOSTS", None)
        return directory, summary(directory), table(directory, "balance.csv")

    def test_the_answer_is_that_of_one_host_and_what_crosses_is_counted(self):
        alone, one, rows = self.run_on(0)
        self.assertEqual((one["hosts"], one["blocks_between_hosts_mean"]), (1, 0))
        self.assertEqual({row["blocks_between_hosts"] for row in rows}, {0})
        crossed = []
        for hosts in (1, 2, 4):
            directory, found, rows = self.run_on(hosts)
            self.assertEqual(found["state_hash"], one["state_hash"])
            self.assertEqual((directory / "history.csv").read_text(), (alone / "history.csv").read_text())
            self.assertEqual(found["hosts"], hosts)
            counts = [row["blocks_between_hosts"] for row in rows]
            self.assertEqual(min(counts) > 0, hosts > 1)
            self.assertTrue(min(counts) <= found["blocks_between_hosts_mean"] <= max(counts))
            crossed.append(found["blocks_between_hosts_mean"])
        self.assertTrue(crossed[0] < crossed[1] < crossed[2], crossed)

    def test_a_cut_that_knows_hosts_crosses_them_less_than_any_that_shuffles(self):
        for ranks in (3, 4):
            with self.subTest(ranks):
                _, one, _ = self.run_on(0, ranks=ranks)
                _, cut, _ = self.run_on(2, ranks=ranks)
                _, in_turn, _ = self.run_on("0,1,0,1", ranks=ranks)
                _, shuffled, _ = self.run_on(2, "--partitioner", "shuffle", ranks=ranks)
                hashes = {found["state_hash"] for found in (cut, in_turn, shuffled)}
                self.assertEqual(hashes, {one["state_hash"]})
                self.assertEqual([found["hosts"] for found in (cut, in_turn, shuffled)], [2, 2, 2])
                for found in (cut, in_turn):
                    self.assertLess(3 * found["blocks_between_hosts_mean"], shuffled["blocks_between_hosts_mean"])
                if ranks == 4:  # hosts of two ranks each: the same cut under other names
                    self.assertEqual(in_turn["blocks_between_hosts_mean"], cut["blocks_between_hosts_mean"])

    def test_where_no_other_owners_fit_the_memory_of_all_it_is_said_once_and_the_answer_is_the_same(self):
        words = [SCENE, *KEYS, *sets(balance__trigger="every")]
        alone = self.run_scene(*words[:1], "alone", *words[1:])
        os.environ["MORAINE_PRETEND_HOSTS"] = "2"
        os.environ["MORAINE_PRETEND_MEMORY"] = "1e6"
        refused = self.assert_one_problem(moraine.call("run", *words, "--output", self.folder / "refused", ranks=4))
        need = float(re.search(r"need ([0-9.e-]+) GB of memory for 4 ranks", refused)[1])
        os.environ["MORAINE_PRETEND_MEMORY"] = str(1.005e9 * need)  # none may hold more than half a per cent over the mean
        ended = moraine.call("run", *words, "--output", self.folder / "full", ranks=4)
        self.assertEqual(ended.code, 0, ended)
        self.assertEqual(ended.err.count("no other owners of blocks fit the memory of all ranks"), 1, ended.err)
        self.assertIn("memory", [row["reason"] for row in table(self.folder / "full", "balance.csv")])
        self.assertEqual(summary(self.folder / "full")["state_hash"], summary(alone)["state_hash"])

    def test_a_number_of_hosts_that_is_none_is_refused(self):
        os.environ["MORAINE_PRETEND_HOSTS"] = "some"
        ended = moraine.call("run", SCENE, "--output", self.folder / "refused", *KEYS, ranks=2)
        self.assertRegex(self.assert_one_problem(ended), "MORAINE_PRETEND_HOSTS = some")


if __name__ == "__main__":
    moraine.main()
