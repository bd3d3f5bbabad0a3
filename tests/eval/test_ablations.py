"""tools/eval/ablations: two tiny trainings, judged; neither is made twice."""

import json
import os
import shutil
import signal
import subprocess
import unittest
from pathlib import Path

from files import ROOT, scratch
from processes import find_processes, wait_until

from study import tables

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

    def test_chosen(self):
        """By part, by name; what there is not is refused."""
        chosen = ablations(DATA, "--list", "--only", "mirror", "paper-small-without-attention").stdout.split()
        without = ["structured-small-without-mirror", "paper-small-without-attention"]
        self.assertEqual(sorted(chosen), sorted(["structured-small", "paper-small", *without]))
        done = ablations(DATA, "--list", "--only", "miror")
        self.assertEqual(done.returncode, 2)
        self.assertIn("--only miror", done.stderr)

    def test_usage(self):
        """What the judging would refuse is refused before anything is trained."""
        shutil.rmtree(OUT, ignore_errors=True)
        self.assertEqual(ablations(DATA, "--steps", "1", "--frames", "none", "--out", str(OUT)).returncode, 2)
        for length in (("--minutes", "soon"), ("--steps", "0"), ("--minutes", "-1")):
            done = ablations(DATA, *length, "--out", str(OUT))
            self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
        self.assertEqual(ablations("--out", str(OUT)).returncode, 2)
        self.assertFalse(OUT.exists())

    def test_no_data(self):
        shutil.rmtree(OUT, ignore_errors=True)
        done = ablations(scratch("nothing"), "--steps", "1", "--out", str(OUT))
        self.assertEqual(done.returncode, 1)
        self.assertIn("manifest.json: No such file", done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1)

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
            *"--steps 2 --jobs 2 --presets structured-small --only mirror --frames 1 --size 32 --spp 2".split(),
            *"--precision fp32".split(),
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
        self.assertEqual(result["training"]["jobs"], 2)
        self.assertEqual(set(result["training"]["steps"].values()), {2})
        self.assertIn("2 at a time", tables.text(tables.of_ablations(result)))
        self.assertIn("products in fp32;", tables.text(tables.of_ablations(result)))
        self.keeps_the_larger_study(command)
        self.refuses_a_mixture(command)
        self.goes_on_after_a_kill()

    def keeps_the_larger_study(self, command):
        """Its tables, when fewer networks are asked for."""
        before = (OUT / "quality.json").read_bytes()
        done = ablations(*command, "--only", "none")
        self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1), done.stderr)
        self.assertIn("is of another study (other networks", done.stderr)
        self.assertEqual((OUT / "quality.json").read_bytes(), before)

    def refuses_a_mixture(self, command):
        """Networks of other lengths of training are not compared."""
        done = ablations(*command[:1], "--steps", "3", *command[3:])
        self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1), done.stderr)
        self.assertIn("length 2 steps", done.stderr)

    def goes_on_after_a_kill(self):
        """Terminated, it leaves checkpoints and goes on from them; killed, its trainings keep others away."""
        out = Path(scratch("long"))
        shutil.rmtree(out, ignore_errors=True)
        command = [os.path.join(ROOT, "tools/eval/ablations"), DATA, *"--steps 100000 --jobs 2 --only mirror".split()]
        command += ["--presets", "structured-small", "--out", str(out)]
        for end, status in ((signal.SIGTERM, 130), (signal.SIGKILL, -signal.SIGKILL)):
            study = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            trained = [out / f"structured-small{part}.log" for part in ("", "-without-mirror")]
            wait_until(lambda: all(log.exists() and "step " in log.read_text() for log in trained))
            study.send_signal(end)
            self.assertEqual(study.wait(), status)
            if end == signal.SIGTERM:
                self.assertEqual(len(list(out.glob("*.checkpoint"))), 2)
                for log in trained:
                    log.unlink()
        self.assertIn("at work there", ablations(*command[1:]).stderr)
        for process in find_processes("train.py", out):
            os.kill(process, signal.SIGTERM)
        wait_until(lambda: not find_processes("train.py", out))
