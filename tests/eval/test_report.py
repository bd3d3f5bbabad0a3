"""The report of a tiny study in a browser: frames and pictures are chosen, tables are there, nothing is loaded."""

import base64
import json
import os
import shutil
import subprocess
import unittest
import zlib
from pathlib import Path

import numpy as np
from browser import Browser
from files import ROOT, scratch
from test_page import COLOR, READY, SET, TEXT, shown

from evaluation.page import _pack
from evaluation.pictures import load
from study import tables
from study.report import _commands

OUT = Path(scratch("out"))
BENCH = {
    "scene": "chess.glb",
    "device": "none",
    "width": 32,
    "height": 32,
    "frames": 1,
    "frame_ms": {"median": 5.0},
    "passes": [{"name": "gather", "cpu_ms": 1.25, "gpu_ms": 0}],
    "memory_mib": 100.0,
    "ratios": {"gather": 0.4321},
}
CHOOSE = SET + "\nreturn new Promise(done => setTimeout(done, 300))"


def run(command, *arguments):
    return subprocess.run(
        [os.path.join(ROOT, "tools/eval", command), *arguments], capture_output=True, text=True, check=False
    )


class Report(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        shutil.rmtree(OUT, ignore_errors=True)
        done = run(
            "quality",
            *"--parts frames temporal unseen --frames 2 --size 32 --spp 2 --unseen-frames 1 --unseen-spp 2 "
            "--moving-frames 2 --moving-size 24 --moving-spp 2 --unseen content/unseen/wall.glb".split(),
            "--out",
            str(OUT),
        )
        assert done.returncode == 0, done.stderr
        (OUT / "bench.json").write_text(json.dumps(BENCH))
        done = run("report", str(OUT), "--bench", str(OUT / "bench.json"), "--show", "1")
        assert done.returncode == 0, done.stderr
        cls.page = Path(done.stdout.strip())
        cls.study = json.loads((OUT / "quality.json").read_text())

    def setUp(self):
        self.browser = self.enterContext(Browser())
        self.browser.open(self.page.as_uri())
        self.browser.run(READY)

    def options(self, name):
        return self.browser.run("return [...document.getElementById(arguments[0]).options].map(o => o.text)", name)

    def test_choices(self):
        self.assertEqual(self.options("frame"), ["chess 900000", "wall 900000", "flight, moving"])
        self.assertEqual(self.options("choice-a"), list(self.study["frames"]["methods"]))
        self.assertEqual(self.options("choice-b")[0], "reference, 2 x 2 spp")

    def test_pictures(self):
        """What is chosen is shown: its pixel, its figures, its map; B may be another method."""
        name, other = "paths 1 spp", "raster"
        self.browser.run(CHOOSE, "choice-a", name)
        self.browser.run(CHOOSE, "choice-b", other)
        found = self.study["frames"]["methods"][name]["frames"][0]
        self.assertEqual(
            self.browser.run("return document.querySelector('#figure-rse td').textContent"), f"{found['rse']:.5f}"
        )
        for key, method in (("a", name), ("b", other)):
            pixels = load(self.study["frames"]["methods"][method]["frames"][0]["picture"]).pixels
            values = self.browser.run(f"return [...layers.{key}.values]")
            np.testing.assert_allclose(values, np.float64(pixels).ravel(), rtol=2**-8, atol=1e-4)
        left, top, width, height = self.browser.run(
            "const b = document.querySelector('.pane').getBoundingClientRect();"
            " return [b.left, b.top, b.width, b.height]"
        )
        middle = load(self.study["frames"]["methods"][other]["frames"][0]["picture"]).pixels[16, 20]
        zoom = self.browser.run("return zoomOf(panes[0])")
        place = left + width / 2 + 4.5 * zoom, top + height / 2 + 0.5 * zoom
        exposure = self.browser.run("return frame.exposure")
        np.testing.assert_allclose(self.browser.run(COLOR, *place), shown(middle, exposure), atol=3)

    def test_frames_of_another_size(self):
        self.browser.run(CHOOSE, "frame", "flight, moving")
        self.assertEqual(self.browser.run("return [width, height, layers.a.canvas.width]"), [24, 24, 24])
        self.assertIn("HDR-FLIP", self.options("map"))

    def test_tables(self):
        text = self.browser.run("return document.querySelector('article').textContent")
        for table in (*tables.of_study(self.study), *tables.of_bench("bench", BENCH)):
            self.assertIn(table.title, text)
            for cell in table.rows[-1]:
                self.assertIn(cell, text)
        for part in ("frames", "temporal", "unseen"):
            for value in (self.study["made"][part][key] for key in ("command", "program")):
                self.assertIn(value, text)
            self.assertIn(self.study["made"][part]["machine"]["cpu"], text)
        self.assertEqual(self.browser.run(TEXT, "title").split("  ")[0], "LightFormer: quality")

    def test_what_it_overwrites(self):
        """The report of the same study, not that of another, and no other file."""
        before = self.page.read_bytes()
        arguments = ("--show", "1", "--bench", str(OUT / "bench.json"))
        self.assertEqual(run("report", str(OUT), *arguments).returncode, 0)
        self.assertEqual(self.page.read_bytes(), before)
        other = OUT / "other"
        other.mkdir(exist_ok=True)
        study = self.study | {"settings": self.study["settings"] | {"size": 33}}
        (other / "quality.json").write_text(json.dumps(study))
        for path in (self.page, OUT / "bench.json"):
            kept = path.read_bytes()
            done = run("report", str(other), "-o", str(path))
            self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1), done.stderr)
            self.assertIn(f"{path}: is there already, and no page about this; --force overwrites it", done.stderr)
            self.assertEqual(path.read_bytes(), kept)
        page = OUT / "forced.html"
        page.write_text("mine")
        self.assertEqual(run("report", str(OUT), "-o", str(page), "--force", *arguments).returncode, 0)
        self.assertEqual(page.read_bytes(), before)

    def test_no_network(self):
        self.assertEqual(self.browser.run("return performance.getEntriesByType('resource').length"), 0)


class Refused(unittest.TestCase):
    def test_no_study(self):
        (OUT / "empty").mkdir(parents=True, exist_ok=True)
        (OUT / "empty" / "quality.json").write_text('{"settings": {}}')
        for name, text in (("numbers", '{"settings": {}, "frames": 3}'), ("lists", '{"settings": {}, "unseen": [1]}')):
            (OUT / name).mkdir(exist_ok=True)
            (OUT / name / "quality.json").write_text(text)
        wrong = "is no result of a study"
        for folder, expected in (("none", "none"), ("empty", "no pictures yet"), ("numbers", wrong), ("lists", wrong)):
            done = run("report", str(OUT / folder))
            self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1), done.stderr)
            self.assertIn(expected, done.stderr)


class Summary(unittest.TestCase):
    @staticmethod
    def method(rse, flip, **more):
        figures = {
            key: {"mean": value, "half": None} for key, value in (("rse", rse), ("hdr_flip", flip), ("mean_ratio", 1))
        }
        return {"spp": 0, "denoiser": None, "figures": figures, "frames": [{"rse": rse}]} | more

    def test_goals(self):
        """Rivals are the paths that fit into our time, and what is denoised; a goal is reached up to its value."""
        methods = {
            "ours": self.method(0.05, 0.2),
            "raster": self.method(1, 1),
            "paths 1 spp": self.method(1, 1, spp=1),
            "paths 2 spp": self.method(0.1, 0.1, spp=2),
            "paths 1 spp + OIDN": self.method(0.04, 0.4, spp=1, denoiser="high"),
        }
        result = {
            "settings": {"networks": {"ours": "0"}, "scene": "chess"},
            "frames": {"methods": methods},
            "time": {"sample": 10, "frame:ours": 29},
            "oidn": {"network": "ours", "ms": 29, "steps": {"high": [{"ms": 20}, {"ms": 58}], "fast": [{"ms": 14.5}]}},
            "unseen": {"wall": {"methods": {"ours": self.method(0.2, 0.1)}}},
        }
        found = {row[0]: row[1:] for row in tables.summary(result)[0].rows}
        self.assertEqual(
            found,
            {
                "RSE": ["0.0500", "0.05", "reached"],
                "HDR-FLIP": ["0.2000", "0.12", "missed"],
                "RSE over that of paths 2 spp": ["0.500", "1", "reached"],
                "RSE over that of paths 1 spp + OIDN": ["1.250", "1", "missed"],
                "HDR-FLIP over that of paths 2 spp": ["2.000", "1", "missed"],
                "HDR-FLIP over that of paths 1 spp + OIDN": ["0.500", "1", "reached"],
                "time over that of paths + OIDN high at the same RSE": ["0.50", "1", "reached"],
                "time over that of paths + OIDN fast at the same RSE": ["2.00", "1", "missed"],
                "RSE on wall over that on chess": ["4.00", "2", "missed"],
            },
        )

    def test_ablations(self):
        """Each is beside the whole network of its own family."""
        methods = {
            "a": self.method(0.1, 0),
            "a-without-x": self.method(0.2, 0),
            "b": self.method(0.5, 0),
            "b-without-x": self.method(0.5, 0),
        }
        training = {"length": "10 minutes", "jobs": 2, "threads": 1, "steps": dict.fromkeys(methods, 7)}
        result = {"settings": {"frames": 1, "size": 1}, "frames": {"methods": methods}, "training": training}
        table = tables.of_ablations(result)[0]
        self.assertEqual([row[3] for row in table.rows], ["1.00", "2.00", "1.00", "1.00"])
        self.assertEqual([row[1] for row in table.rows], ["7"] * 4)
        self.assertIn("10 minutes, 2 at a time, 1 thread", table.note)


class Making(unittest.TestCase):
    """What made each part."""

    MACHINE = {"cpu": "chip", "threads": 2, "memory_gib": 8, "system": "Linux 1"}

    def rows(self, *results):
        return [row[:3] for row in tables.of_making(*results)[0].rows]

    def test_parts_of_two_programs(self):
        other = {"command": "b", "program": "2", "machine": self.MACHINE | {"threads": 64}}
        made = {"time": {"command": "a", "program": "1", "machine": self.MACHINE}, "frames": other}
        result = {"made": made, "frames": {}, "time": {}}
        self.assertEqual(self.rows(result), [["time", "1", "chip, 2 threads"], ["frames", "2", "chip, 64 threads"]])
        self.assertIn("Not all parts", tables.of_making(result)[0].note)
        del result["time"]
        self.assertNotIn("Not all parts", tables.of_making(result)[0].note)

    def test_results_that_say_it_once(self):
        """The program is not known; commands are in the report."""
        once = {"command": "a", "machine": self.MACHINE, "frames": {}, "unseen": {}}
        ablations = once | {"command": "c"}
        rows = [[name, "–", "chip, 2 threads"] for name in ("frames", "unseen", "ablations")]
        self.assertEqual(self.rows(once, ablations), rows)
        self.assertIn("<pre># frames, unseen\na\n# ablations\nc\n", _commands(once, ablations))


class Bench(unittest.TestCase):
    def test_growth(self):
        """Lights and pieces have a table of their own, and none where only a frame was measured."""
        step = {"encode_ms": 2.0, "gather_ms": 1.0, "network_ms": 1.5}
        budget = {"frame_ms": 4.0, "sample_ms": 2.0, "budget_ms": {"gather": 1.0}}
        growth = {"lights": [step | {"count": 16}], "pieces": [step | {"count": 33}]}
        more = {"encode_slope_ms": 1, "gather_slope_ms": 0.5, "memory_mib": 600, "first_frame_s": 2}
        titles = [table.title for table in tables.of_bench("b", {"neural": budget})]
        self.assertEqual(titles, ["Budget of a frame: b"])
        grown = tables.of_bench("b", {"neural": budget | growth | more})[1]
        self.assertEqual(grown.rows, [["16 lights", "2.0", "1.0", "1.5"], ["33 pieces", "2.0", "1.0", "1.5"]])


class Packing(unittest.TestCase):
    def test_fewer_bits(self):
        """Seven bits of mantissa: within half of 2^-7; no number stays none, what is too large stays finite."""
        values = np.array([0.0, 1.0, -1.0, 0.1, 3.14159, 65504.0, 1e9, -1e9, np.nan, 2e-7, 1000.3])
        read = np.frombuffer(zlib.decompress(base64.b64decode(_pack(values, 7))), "<f2").astype(float)
        np.testing.assert_allclose(read[:5], values[:5], rtol=2**-8)
        self.assertTrue(np.isfinite(read[5:8]).all() and read[7] < -60000 and np.isnan(read[8]))
        self.assertAlmostEqual(read[10], 1000.3, delta=4)
