"""tools/eval/ablations: two tiny trainings, judged; neither is made twice."""

import json
import os
import shutil
import subprocess
import unittest
from pathlib import Path

from files import ROOT, scratch

OUT, DATA = Path(scratch("out")), scratch("data")
HAS_TORCH = subprocess.run(["/usr/bin/python3", "-c", "import torch"], capture_output=True, check=False).returncode == 0


def ablations(*arguments):
    return subprocess.run(
        [os.path.join(ROOT, "tools/eval/ablations"), *arguments], capture_output=True, text=True, check=False
    )


class Ablations(unittest.TestCase):
    def test_list(self):
        names = ablations(DATA, "--list").stdout.split()
        self.assertIn("structured-small-without-mirror", names)
        self.assertIn("paper-small-without-attention", names)
        self.assertEqual(names, sorted(set(names), key=names.index))

    def test_usage(self):
        """What the judging would refuse is refused before anything is trained."""
        shutil.rmtree(OUT, ignore_errors=True)
        self.assertEqual(ablations(DATA, "--steps", "1", "--frames", "none", "--out", str(OUT)).returncode, 2)
        self.assertFalse(OUT.exists())

    def test_no_data(self):
        shutil.rmtree(OUT, ignore_errors=True)
        done = ablations(scratch("nothing"), "--steps", "1", "--out", str(OUT))
        self.assertEqual(done.returncode, 1)
        self.assertIn("train: ", done.stderr.splitlines()[-1])

    @unittest.skipUnless(HAS_TORCH, "no PyTorch (tools/setup --train)")
    def test_trained_and_judged(self):
        for folder in (OUT, DATA):
            shutil.rmtree(folder, ignore_errors=True)
        subprocess.run(
            [
                os.environ["LIGHTFORMER"],
                "dataset",
                os.path.join(ROOT, "content/chess/chess.glb"),
                "-o",
                DATA,
                *"--count 4 --size 64 --crop 32 --spp 1 --shard 16".split(),
            ],
            check=True,
            capture_output=True,
        )
        command = (
            DATA,
            *"--steps 2 --presets structured-small --only mirror --frames 1 --size 32 --spp 2".split(),
            "--out",
            str(OUT),
        )
        first = ablations(*command)
        self.assertEqual(first.returncode, 0, first.stderr)
        result = json.loads((OUT / "quality.json").read_text())
        self.assertEqual(list(result["frames"]["methods"]), ["structured-small", "structured-small-without-mirror"])
        trained = {path: path.stat().st_mtime_ns for path in OUT.glob("*.safetensors")}
        self.assertEqual(len(trained), 2)
        self.assertEqual(ablations(*command).stdout, first.stdout)
        self.assertEqual(trained, {path: path.stat().st_mtime_ns for path in trained})
