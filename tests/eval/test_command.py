"""tools/eval/compare from outside, beside `lightformer compare`: the same figures, the same refusals."""

import json
import os
import subprocess
import unittest

import numpy as np
from files import ROOT, radiance, scratch, write_exr
from PIL import Image

PROGRAMS = [os.path.join(ROOT, "tools/eval/compare")], [os.environ["LIGHTFORMER"], "compare"]


def run(program, *arguments):
    return subprocess.run([*program, *arguments], capture_output=True, text=True, check=False)


def both(*arguments):
    """The JSON of the two programs."""
    results = []
    for program in PROGRAMS:
        done = run(program, *arguments, "--json")
        assert done.returncode == 0, done.stderr
        results.append(json.loads(done.stdout))
    return results


class Command(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        depth = np.zeros((48, 64), np.float32)
        depth[:, 20:] = 1
        cls.a = write_exr("a.exr", beauty=radiance(64, 48, 1) * 1.2, indirect=radiance(64, 48, 5), depth__Z=depth)
        cls.b = write_exr("b.exr", beauty=radiance(64, 48, 2), indirect=radiance(64, 48, 6), depth__Z=depth)
        cls.b2 = write_exr("b2.exr", beauty=radiance(64, 48, 3))

    def assert_same(self, *arguments):
        ours, theirs = both(*arguments)
        for key in ("rse", "l1", "psnr", "mean_ratio"):
            self.assertAlmostEqual(ours[key], theirs[key], delta=1e-5 * abs(theirs[key]), msg=(key, arguments))
        self.assertEqual(ours["pixels"], theirs["pixels"])
        return theirs

    def test_same_figures(self):
        whole = self.assert_same(self.a, self.b)
        self.assert_same(self.a, self.b, self.b2)
        self.assert_same(self.a, self.b, "--layer", "indirect")
        masked = self.assert_same(self.a, self.b, "--mask-layer", "depth")
        self.assertEqual((whole["pixels"], masked["pixels"]), (64 * 48, 44 * 48))
        for i in range(2):
            pixels = np.random.default_rng(i).integers(0, 255, (20, 20, 3), np.uint8)
            Image.fromarray(pixels).save(scratch(f"{i}.png"))
        self.assert_same(scratch("0.png"), scratch("1.png"))

    def test_equal_pictures(self):
        for result in both(self.a, self.a):
            self.assertEqual((result["rse"], result["l1"], result["psnr"], result["mean_ratio"]), (0, 0, None, 1))

    def test_refused(self):
        """One line on standard error, the same of both, and exit code 1."""
        nan = radiance(64, 48, 1)
        nan[7, 5, 1] = np.nan
        bad = write_exr("nan.exr", beauty=nan)
        black = write_exr("black.exr", beauty=np.zeros((48, 64, 3), np.float32))
        small = write_exr("small.exr", beauty=radiance(32, 48, 1))
        text = scratch("text.exr")
        with open(text, "w", encoding="ascii") as file:
            file.write("not a picture")
        for expected, *arguments in (
            ("is 32 x 48 pixels", small, self.b),
            ('no layer "shadow"; it has depth, indirect', self.a, self.b, "--layer", "shadow"),
            ("pixel (5, 7) is", bad, self.b),
            ("pixel (5, 7) is", self.a, self.b, bad),
            ("no pixel is left", self.a, self.b, "--mask", black),
            ("the mean is 0", self.a, black),
            ("neither an OpenEXR nor a PNG", text, self.b),
            ("/none.exr", "/none.exr", self.b),
        ):
            for program in PROGRAMS:
                done = run(program, *arguments)
                self.assertEqual(done.returncode, 1, (program, arguments))
                self.assertEqual(done.stderr.count("\n"), 1, done.stderr)
                self.assertIn(expected, done.stderr)
                self.assertEqual(done.stdout, "")

    def test_usage(self):
        for program in PROGRAMS:
            self.assertEqual(run(program).returncode, 2)
            self.assertEqual(run(program, self.a, self.b, "--no-such-option").returncode, 2)
        self.assertEqual(run(PROGRAMS[0], self.a, self.b, "--frames", "3..1").returncode, 2)

    def test_sequence(self):
        """Three frames of a still reference; the second of A is brighter, so it flickers twice."""
        b, still = radiance(40, 40, 9), np.zeros((40, 40), np.float32)
        for n, gain in enumerate((1, 1.5, 1)):
            write_exr(f"sa.{n:04}.exr", beauty=b * gain)
            write_exr(f"sb.{n:04}.exr", beauty=b, motion__X=still, motion__Y=still)
        done = run(PROGRAMS[0], scratch("sa.exr"), scratch("sb.exr"), "--frames", "0..2", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        result = json.loads(done.stdout)
        self.assertEqual([frame["frame"] for frame in result["frames"]], [0, 1, 2])
        self.assertIsNone(result["frames"][0]["temporal"])
        self.assertAlmostEqual(result["temporal"], 0.5, places=5)
        self.assertAlmostEqual(result["mean_ratio"], 3.5 / 3, places=5)
