"""Terrain as a user meets it: one answer on any number of ranks and after a restart, and words for models and areas
that are wrong."""
import math
import re
import unittest

import moraine
from moraine import call, checkpoints, sets, summary
from valley import AREA, GDAL, SCENE, ZONE, ValleyTest, features, grid, heights, read_map


class Terrain(ValleyTest):
    def test_state_and_maps_are_the_same_on_1_to_4_ranks_and_after_a_restart(self):
        one = self.run_scene(self.scene, "one", *sets(output__checkpoint_interval=0.5))
        self.assertEqual(len(self.maps(one)), 2 * 6 + 1)  # each with a style, and the outline
        for ranks in (2, 3, 4):
            many = self.run_scene(self.scene, f"r{ranks}", "--partitioner", "shuffle",
                                  *sets(balance__trigger="every", balance__interval=20), ranks=ranks)
            self.assertEqual(summary(many)["state_hash"], summary(one)["state_hash"])
            self.assertEqual(self.maps(many), self.maps(one))
            self.assertEqual(summary(many)["structures"], summary(one)["structures"])
        again = self.run_scene(self.scene, "again", "--restart", checkpoints(one)[0], ranks=2)
        self.assertEqual(summary(again)["state_hash"], summary(one)["state_hash"])
        self.assertEqual(self.maps(again), self.maps(one))

    @unittest.skipUnless(GDAL, "a build without GDAL")
    def test_a_release_is_taken_to_the_system_of_the_model(self):
        plain = self.run_scene(self.scene, "plain", *sets(time__end=0))
        self.write(ZONE, "valley.prj")
        corners = [[float(x) for x in line.split(",")] for line in AREA.split()[1:]]
        degrees = [[9 + x / 111319.490793, y / 110574.2758] for x, y in corners]
        self.write(features((degrees, {"thickness": 1.0})), "area.geojson")
        self.write(SCENE.replace("area.csv", "area.geojson").replace("thickness = 1.0\n", ""))
        ended = call("run", self.scene, "--output", self.folder / "warped", "--device", "cpu", *sets(time__end=0))
        self.assertEqual(ended.code, 0, ended)
        self.assertIn("area.geojson: reprojected from WGS 84 (EPSG:4326) to zone, the model's.", ended.err)
        self.assertAlmostEqual(summary(self.folder / "warped")["mass_kg"] / summary(plain)["mass_kg"], 1, delta=1e-4)

    def test_rasters_of_the_bed_hold_where_they_know_a_value(self):
        plain = self.run_scene(self.scene, "plain")
        with_bed = SCENE.replace("[hazard]", 'friction = "mu.asc"\nxi = "xi.asc"\n[hazard]').replace(
            'dem = "valley.asc"\ncontact = { law = "voellmy", friction = 0.2, xi = 500.0 }',
            'dem = "valley.asc"\ncontact = { law = "voellmy", friction = 0.9, xi = 500.0 }')
        self.write(grid(at=lambda x, y: 0.2), "mu.asc")
        self.write(grid(at=lambda x, y: -9999), "xi.asc")
        self.write(with_bed)
        same = self.run_scene(self.scene, "same")
        for name in ("max_depth", "arrival", "deposit"):  # tags have what the scenes say
            self.assertEqual(read_map(same, name), read_map(plain, name))
        self.write(grid(at=lambda x, y: 0.2 if x < 6 else 0.8), "mu.asc")
        rough = self.run_scene(self.scene, "rough")
        two = self.run_scene(self.scene, "two", "--partitioner", "shuffle", ranks=2)
        self.assertEqual(self.maps(two), self.maps(rough))
        beyond = [sum(sum(row[7:]) for row in read_map(run, "max_speed")) for run in (rough, plain)]
        self.assertLess(beyond[0], 0.98 * beyond[1])

    def test_a_raster_that_does_not_fit_is_refused_with_file_and_reason(self):
        scene = SCENE.replace("[hazard]", 'friction = "mu.asc"\n[hazard]')
        mu = lambda at: self.write(grid(at=at), "mu.asc")
        self.assertIn("no such file", self.refused(scene))
        mu(lambda x, y: -0.1)
        self.assertIn("mu.asc: a friction of -0.1 (must be >= 0)", self.refused(scene))
        self.write(grid().replace("xllcenter 0", "xllcenter 100"), "mu.asc")
        self.assertIn("mu.asc: the raster of friction reaches from 99 to 125 along x", self.refused(scene))
        mu(lambda x, y: 0.1)
        self.assertIn("terrain.friction is not used", self.refused(scene.replace(
            'law = "voellmy", friction = 0.2, xi = 500.0', 'law = "rough"')))
        self.assertIn("terrain.xi is not used", self.refused(scene.replace('friction = "mu.asc"', 'xi = "mu.asc"').replace(
            'law = "voellmy", friction = 0.2, xi = 500.0', 'law = "coulomb", friction = 0.2')))

    def test_the_thickness_of_a_release_may_be_a_raster(self):
        self.write(grid(at=lambda x, y: 1.0), "deep.asc")
        raster = SCENE.replace("thickness = 1.0", 'thickness = "deep.asc"')
        plain = self.run_scene(self.scene, "plain", *sets(time__end=0))
        self.write(raster)
        same = self.run_scene(self.scene, "same", *sets(time__end=0))
        self.assertEqual(summary(same)["state_hash"], summary(plain)["state_hash"])
        self.write(grid(at=lambda x, y: 0.25 * y), "deep.asc")
        wedge = self.run_scene(self.scene, "wedge", *sets(time__end=0))
        ratio = summary(wedge)["mass_kg"] / summary(plain)["mass_kg"]
        self.assertGreater(ratio, 0.25 * 3)
        self.assertLess(ratio, 0.25 * 9)
        two = self.run_scene(self.scene, "two", *sets(time__end=0), ranks=2)
        self.assertEqual(summary(two)["state_hash"], summary(wedge)["state_hash"])
        self.write(grid(at=lambda x, y: 0.3), "deep.asc")
        self.assertIn("deep.asc: release.scar is at most 0.3 m thick (less than a cell", self.refused(raster))
        self.write(grid(at=lambda x, y: -9999 if x == 4 and y == 6 else 1), "deep.asc")
        self.assertIn("deep.asc: no thickness at (4, 6)", self.refused(raster))
        self.assertIn("release.scar.thickness is missing", self.refused(SCENE.replace("thickness = 1.0\n", "")))

    @unittest.skipUnless(GDAL, "a build without GDAL")
    def test_every_polygon_of_a_file_is_a_body_with_its_own_thickness(self):
        low, high = [[2, 3], [6, 3], [6, 5.5], [2, 5.5]], [[2, 6.5], [6, 6.5], [6, 9], [2, 9]]
        self.write(features((low, {"thickness": 1}), (high, {"thickness": 2})), "area.geojson")
        self.write(SCENE.replace("area.csv", "area.geojson").replace("thickness = 1.0\n", ""))
        ended = call("check", self.scene, "--device", "cpu")
        self.assertEqual(ended.code, 0, ended)
        self.assertRegex(ended.out, r"release    scar-1: \S+ m3, 2 cells thick")
        self.assertRegex(ended.out, r"release    scar-2: \S+ m3, 4 cells thick\n")
        self.assertIn("area.geojson: release.scar-2.thickness = 0.3 (less than a cell",
                      self.refused(features((low, {"thickness": 1}), (high, {"thickness": 0.3})), "area.geojson"))

    DOMAIN = "min = [0.0, 0.0, 0.0]\nmax = [24.0, 12.0, 16.0]\n"

    def test_a_domain_that_is_left_out_is_that_of_the_model(self):
        said = self.run_scene(self.scene, "said")
        self.write(SCENE.replace(self.DOMAIN, ""))
        ended = call("check", self.scene, "--device", "cpu")
        self.assertEqual(ended.code, 0, ended)
        self.assertRegex(ended.out, r"domain     from 0 0 -3.5 to 24 12 21.5 m")
        left_out = self.run_scene(self.scene, "left_out", *sets(output__checkpoint_interval=0.5))
        for name in ("max_depth", "deposit"):
            for one, other in zip(read_map(said, name), read_map(left_out, name)):
                for a, b in zip(one, other):
                    self.assertAlmostEqual(a, b, places=6)
        self.assertEqual(summary(left_out)["lost_particles"], 0)
        again = self.run_scene(self.scene, "again", "--restart", checkpoints(left_out)[0], ranks=2)
        self.assertEqual(summary(again)["state_hash"], summary(left_out)["state_hash"])
        self.assertIn("domain.max is missing (domain.min is there)",
                      self.changed(self.DOMAIN, "min = [0.0, 0.0, 0.0]\n"))
        plain = SCENE[:SCENE.index("[terrain]")] + SCENE[SCENE.index("[[material]]"):SCENE.index("[[release]]")]
        self.assertIn("domain.min is missing", self.refused(plain.replace(self.DOMAIN, "")))

    def test_a_crop_lays_the_domain_around_its_polygon(self):
        self.write("x,y\n1.2,2.1\n10.9,3\n8,10.7\n", "crop.csv")
        cropped = SCENE.replace(self.DOMAIN, "").replace("[hazard]", 'crop = "crop.csv"\n[hazard]')
        self.write(cropped)
        ended = call("check", self.scene, "--device", "cpu")
        self.assertEqual(ended.code, 0, ended)
        self.assertIn("domain     from 1 2 ", ended.out)
        self.assertRegex(ended.out, r" to 11 11 \S+ m\n")
        directory = self.run_scene(self.scene, "run")
        self.assertEqual((len(read_map(directory, "deposit")), len(read_map(directory, "deposit")[0])), (9, 10))
        self.assertIn("terrain.crop is not used (domain.min and domain.max say where the domain is)",
                      self.refused(SCENE.replace("[hazard]", 'crop = "crop.csv"\n[hazard]')))
        self.write(cropped)
        self.assertIn("crop.csv: the crop reaches from 1.2 to 40 along x (the model from -1 to 25)",
                      self.refused("x,y\n1.2,2\n40,3\n8,10\n", "crop.csv"))
        self.assertIn("has a corner at", self.refused("x,y\n12,2\n20,3\n18,10\n", "crop.csv"))
        self.assertIn("no such file", self.refused(cropped.replace("crop.csv", "absent.csv")))

    def test_a_ground_that_bends_sharply_is_told_and_smoothed(self):
        self.write(grid(25, 13, 1.0, lambda x, y: max(0, 8 - x) + 1), "valley.asc")
        ended = call("check", self.scene, "--device", "cpu")
        self.assertRegex(ended.out, r"least radius of curvature 0\.\d+ m\nwarning    that is less than 5 cells: .+terrain.smooth = 2.5,")
        smooth = SCENE.replace("[hazard]", "smooth = 4.0\n[hazard]")
        self.write(smooth)
        ended = call("check", self.scene, "--device", "cpu")
        self.assertEqual(ended.code, 0, ended)
        self.assertRegex(ended.out, r"valley.asc: smoothed from a least radius of curvature of 0\S+ m to 4\S* m; heights")
        self.assertNotIn("less than 5 cells", ended.out)
        one = self.run_scene(self.scene, "one", *sets(time__end=0.5))
        two = self.run_scene(self.scene, "two", *sets(time__end=0.5), ranks=2)
        self.assertEqual(summary(one)["state_hash"], summary(two)["state_hash"])
        self.assertIn("terrain.smooth = 0", self.refused(smooth.replace("smooth = 4.0", "smooth = 0.0")))
        self.assertIn("cannot be brought there", self.refused(smooth.replace("smooth = 4.0", "smooth = 1e9")))

    def test_debris_stays_over_the_ground_and_leaves_by_open_sides(self):
        directory = self.run_scene(self.scene, "out", *sets(time__end=4, domain__max="[12.0, 12.0, 16.0]"))
        self.assertGreater(summary(directory)["lost_particles"], 50)

    def test_check_says_what_the_terrain_is(self):
        ended = call("check", self.scene, "--device", "cpu")
        self.assertEqual(ended.code, 0, ended)
        self.assertRegex(ended.out, r"terrain    13 x 7 heights, 2 m apart, from 1\S* to 1\d\S* m")
        self.assertRegex(ended.out, r"release    scar: \S+ m3, 2 cells thick\n")

    def test_a_wrong_model_is_refused_with_place_and_remedy(self):
        self.assertIn("no such file", self.changed("valley.asc", "absent.asc"))
        self.assertIn("no such file", self.changed("valley.asc", "valley.tif"))
        self.assertIn("terrain.dem is missing", self.changed('dem = "valley.asc"\n', ""))
        self.assertIn("terrain.profile is not used", self.changed('dem = "valley.asc"', 'profile = "valley.csv"'))
        self.assertIn("Did you mean terrain.contact.friction?", self.changed("friction = 0.2", "frction = 0.2"))
        self.assertIn("terrain.contact.xi is missing", self.changed(", xi = 500.0", ""))
        self.write(SCENE)
        self.assertIn("from -1 to 23 along x (the domain from 0 to 24)", self.refused(grid(12), "valley.asc"))
        holes = grid(at=lambda x, y: -9999 if x == 4 and y == 6 else heights(x, y))
        self.assertIn("no height at (4, 6)", self.refused(holes, "valley.asc"))
        with open(self.folder / "valley.asc", "w") as model:
            model.write(grid().replace("ncols 13", "ncols 50000").replace("nrows 7", "nrows 40000"))
            model.truncate(4100000000)  # a hole
        self.assertIn("valley.asc:7: 2e+09 heights (a grid of text is read whole: 16 GB",
                      self.assert_one_problem(call("check", self.scene, "--device", "cpu")))
        self.assertIn("valley.asc: no height at (2, 12)",
                      self.refused(grid(at=lambda x, y: math.nan if (x, y) == (2, 12) else 1), "valley.asc"))

    def test_what_a_model_does_not_know_beyond_the_domain_is_not_asked_for(self):
        slope = lambda x, y: 20 - 0.5 * x
        known = sets(domain__min="[2.0, 0.0, -1.0]", domain__max="[22.0, 12.0, 30.0]", time__end=0.2)
        mass = re.search("mass .*", self.checked_with(grid(at=slope), *known))[0]
        margin = grid(at=lambda x, y: -3.4028235e+38 if x in (0, 24) else slope(x, y))
        self.assertIn(mass, self.checked_with(margin, *known))
        one = self.run_scene(self.scene, "one", *known)
        two = self.run_scene(self.scene, "two", *known, ranks=3)
        self.assertEqual(summary(one)["state_hash"], summary(two)["state_hash"])
        self.write(SCENE)
        self.assertIn("valley.asc: no height at (0, 0) (the model has no data there, under the domain)",
                      self.assert_one_problem(call("check", self.scene, "--device", "cpu")))

    def checked_with(self, model, *words):
        self.write(model, "valley.asc")
        ended = call("check", self.scene, "--device", "cpu", *words)
        self.assertEqual(ended.code, 0, ended)
        return ended.out

    def test_a_wrong_release_is_refused_with_place_and_remedy(self):
        self.assertIn("less than a cell", self.changed("thickness = 1.0", "thickness = 0.3"))
        self.assertIn("release.scar.material", self.changed('material = "debris"', 'material = "mud"'))
        self.assertIn("release.scar without ground",
                      self.refused(SCENE.replace(SCENE[SCENE.index("[terrain]"):SCENE.index("[[material]]")], "")))
        self.write(SCENE)
        self.assertIn("area.csv: release.scar has a corner at (30, 3)",
                      self.refused(AREA.replace("6,3.5", "30,3"), "area.csv"))
        self.assertIn("area.csv: release.scar crosses itself", self.refused("x,y\n2,3\n6,8\n6,3\n2,8\n", "area.csv"))
        self.assertIn("area.csv: release.scar has no area", self.refused("x,y\n2,3\n6,8\n4,5.5\n", "area.csv"))


if __name__ == "__main__":
    moraine.main()
