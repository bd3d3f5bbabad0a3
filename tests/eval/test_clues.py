"""tools/eval/clues on one frame."""

import os
import subprocess
import unittest
from pathlib import Path

import numpy as np
from evaluation import BadInput
from files import ROOT, scratch

from study.clues import Clues, encode
from study.renderer import Renderer


def clues(*arguments):
    return subprocess.run(
        [os.path.join(ROOT, "tools/eval/clues"), *arguments], capture_output=True, text=True, check=False
    )


class Command(unittest.TestCase):
    def test_table(self):
        """Kinds of surfaces fill the picture; clues are worth something, each in its own columns."""
        done = clues("--seeds", "900000", "--spp", "4", "--pictures", scratch("pictures"))
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = [line for line in done.stdout.splitlines() if line.startswith(("metals", "glossy", "rough"))]
        self.assertEqual(len(rows), 3)
        cells = [row[20:].split() for row in rows]
        self.assertAlmostEqual(sum(float(row[0]) for row in cells), 1, delta=0.05)
        self.assertTrue(all(0 < float(row[1]) < 0.05 for row in cells))
        self.assertEqual(cells[0][-2:], ["–", "–"])
        self.assertEqual([row[2] for row in cells[1:]], ["–", "–"])

    def test_refused(self):
        done = clues("--scene", "content/LICENSES.md", "--pictures", scratch("pictures"))
        self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1), done.stderr)

    def test_seeds(self):
        for seed in ("-5", "4294967296", "x"):
            done = clues("--seeds", "0", seed, "--pictures", scratch("pictures"))
            self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
            self.assertIn(f"argument --seeds: a whole number from 0 to 4294967295 is needed, not '{seed}'", done.stderr)

    def test_no_shard(self):
        """A program that ends well and makes nothing."""
        renderer = Renderer(Path(scratch("empty")), Path("/bin/true"))
        with self.assertRaisesRegex(BadInput, "no shard of a data set is there; is /bin/true lightformer"):
            encode(renderer, Path(ROOT, "content/unit/light_point.glb"), 0)

    def test_no_picture(self):
        done = clues("--program", "/bin/true", "--pictures", scratch("none"))
        self.assertEqual((done.returncode, done.stderr), (1, "error: /bin/true: made no picture; is it lightformer?\n"))


class Sums(unittest.TestCase):
    def test_lights_count_by_their_shares(self):
        ones = np.ones((1, 2, 3, 1, 1), np.float16)
        found = Clues({"light.share": np.float32([[0.25], [0.5]]), "frame.radiance": np.float32([4]), "view.x": ones})
        np.testing.assert_allclose(found.summed(found.of("view.x")), np.full((3, 1, 1), 3))


if __name__ == "__main__":
    unittest.main()
