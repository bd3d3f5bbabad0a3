"""tools/eval/quality on tiny pictures, and what its figures are made of."""

import json
import os
import shutil
import signal
import subprocess
import unittest
from pathlib import Path

import numpy as np
from files import ROOT, radiance, scratch, write_exr
from processes import find_processes, wait_until

from evaluation import BadInput
from lightformer_train.files import locked
from study import figures, methods, sequence, tables, timing
from study.figures import Truth
from study.methods import denoise, guides
from study.quality import earlier_result, parse, settings_of
from study.renderer import Renderer, digest, scene_digest, variation

OUT = Path(scratch("out"))
TINY = ("--frames", "2", "--size", "48", "--spp", "4", "--out", str(OUT))


def quality(*arguments):
    return subprocess.run(
        [os.path.join(ROOT, "tools/eval/quality"), *arguments], capture_output=True, text=True, check=False
    )


class Command(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        shutil.rmtree(OUT, ignore_errors=True)
        cls.done = quality(*TINY, "--parts", "frames", "--paths", "8")
        assert cls.done.returncode == 0, cls.done.stderr
        cls.result = json.loads((OUT / "quality.json").read_text())

    def test_rows(self):
        methods = self.result["frames"]["methods"]
        self.assertEqual(
            list(methods), ["raster", "paths 1 spp", "paths 8 spp", "paths 1 spp + OIDN", "paths 1 spp + OIDN fast"]
        )
        rse = {name: method["figures"]["rse"]["mean"] for name, method in methods.items()}
        self.assertLess(rse["paths 8 spp"], rse["paths 1 spp"])
        self.assertLess(rse["paths 1 spp + OIDN"], rse["paths 1 spp"])
        layers = methods["paths 8 spp"]["figures"]["layers"]
        self.assertAlmostEqual(layers["unshadowed"]["mean_ratio"]["mean"], 1, delta=0.1)
        self.assertNotIn("indirect", methods["raster"]["figures"]["layers"])

    def test_printed(self):
        """The table is the result's, and its pictures are there."""
        self.assertIn(tables.text(tables.of_study(self.result)), self.done.stdout)
        for method in self.result["frames"]["methods"].values():
            for frame in method["frames"]:
                self.assertTrue(Path(frame["picture"]).exists())

    def test_terminated(self):
        """What it has begun ends with it, also where two methods are judged at a time."""
        out = Path(scratch("long"))
        shutil.rmtree(out, ignore_errors=True)
        command = [os.path.join(ROOT, "tools/eval/quality"), *"--frames 1 --size 48 --spp 1 --parts frames".split()]
        command += ["--paths", "1000000", "--out", str(out)]
        study = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        wait_until(lambda: study.poll() is not None or len(list(out.glob("pictures/*.exr"))) > 4)
        study.send_signal(signal.SIGTERM)
        self.assertEqual(study.wait(), 130)
        self.assertEqual(find_processes("lightformer", out), [])

    def test_resumed(self):
        """Nothing is made twice: only a picture that is missing is made, the same again."""
        lost = Path(self.result["frames"]["methods"]["raster"]["frames"][1]["picture"])
        before = {path: path.stat().st_mtime_ns for path in (OUT / "pictures").iterdir()}
        lost.unlink()
        done = quality(*TINY, "--parts", "frames", "--paths", "8")
        self.assertEqual(done.stdout, self.done.stdout)
        changed = [path for path in (OUT / "pictures").iterdir() if before.get(path) != path.stat().st_mtime_ns]
        self.assertEqual(changed, [lost])

    def test_parts_keep_what_made_them(self):
        """Those of another run, and of a file that says it once for all parts."""
        out = Path(scratch("parts"))
        shutil.rmtree(out, ignore_errors=True)
        tiny = "--frames 1 --size 48 --spp 1 --unseen-frames 1 --unseen-spp 1 --only-networks".split()
        tiny += ["--unseen", os.path.join(ROOT, "content/unseen/wall.glb"), "--out", str(out)]
        self.assertEqual(quality(*tiny, "--parts", "frames").returncode, 0)
        result = json.loads((out / "quality.json").read_text())
        frames = result["made"]["frames"]
        self.assertRegex(frames["command"], "--parts frames$")
        self.assertEqual(frames["program"], Renderer(out / "pictures").version)
        del result["made"]
        once = {"command": "before", "machine": frames["machine"]}
        (out / "quality.json").write_text(json.dumps(result | once))
        done = quality(*tiny, "--parts", "unseen")
        self.assertEqual(done.returncode, 0, done.stderr)
        result = json.loads((out / "quality.json").read_text())
        self.assertEqual(result["made"]["frames"], once | {"program": None})
        self.assertEqual(result["made"]["unseen"], frames | {"command": result["made"]["unseen"]["command"]})
        self.assertRegex(result["made"]["unseen"]["command"], "--parts unseen$")
        self.assertIn("Not all parts are of one program", done.stdout)

    def test_another_study_stays(self):
        """Tables of other sizes or seeds are not overwritten by the way, nor is what cannot be read."""
        result = OUT / "quality.json"
        before = result.read_bytes()
        done = quality(*TINY, "--parts", "frames", "--spp", "2")
        self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1), done.stderr)
        self.assertIn(f"{result}: is of another study (spp 4, not 2); choose another --out", done.stderr)
        self.assertEqual(result.read_bytes(), before)
        for expected, *more in (("frames 2, not 1", "--frames", "1"), ("seeds 900000, not 7", "--seeds", "7")):
            options = parse([*TINY, *more])
            with self.assertRaisesRegex(BadInput, f"is of another study .{expected}"):
                earlier_result(options, settings_of(options, {}))
        options = parse(["--out", scratch("damaged")])
        options.out.mkdir(exist_ok=True)
        for text in ("{", '{"settings": 3}', "[1]"):
            (options.out / "quality.json").write_text(text)
            with self.assertRaisesRegex(BadInput, "quality.json: "):
                earlier_result(options, settings_of(options, {}))

    def test_one_study_at_a_time(self):
        with locked(OUT / "lock", "this test"):
            done = quality(*TINY, "--force")
        self.assertEqual(done.returncode, 1)
        self.assertEqual(done.stderr, f"error: {OUT}: another study, or a training that it began, is at work there\n")

    def test_what_may_be_overwritten(self):
        """More networks and all that was judged, or by force."""
        options = parse([*TINY, "--parts", "frames", "--out", scratch("more")])
        options.out.mkdir(exist_ok=True)
        one, two = (settings_of(options, networks) for networks in ({"a": "1"}, {"a": "1", "b": "2"}))
        for earlier, now, parts, kept in (
            (one, one, {"frames": 1}, True),
            (one, two, {"frames": 1}, False),
            (one, two, {"frames": 1, "time": 1}, None),
            (two, one, {"frames": 1}, None),
            (one, settings_of(options, {"a": "3", "b": "2"}), {"frames": 1}, None),
        ):
            (options.out / "quality.json").write_text(json.dumps({"settings": earlier} | parts))
            options.force = False
            if kept is None:
                with self.assertRaisesRegex(BadInput, "another study .other networks"):
                    earlier_result(options, now)
                options.force = True
            self.assertEqual(earlier_result(options, now), {"settings": earlier} | parts if kept else {})

    def test_refused(self):
        licenses = ("--scene", "content/LICENSES.md")
        for expected, *arguments in (
            ("no/such.glb", "--scene", "no/such.glb"),
            ("lightformer render content/LICENSES.md", *licenses, "--parts", "frames", "--out", scratch("licenses")),
            ("no such program", "--program", "/none"),
            ("/bin/true: bench --json", "--program", "/bin/true", "--parts", "time"),
            ("none.safetensors", "none.safetensors", "--parts", "frames"),
        ):
            done = quality(*TINY, *arguments)
            self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1), done.stderr)
            self.assertIn(expected, done.stderr)
        for arguments in (
            ("a.safetensors", "b/a.safetensors"),
            *(("--frames", "0"), ("--seeds", "-5"), ("--size", "many"), ("--parts", "all"), ("--no-such-option",)),
        ):
            done = quality(*arguments)
            self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)


class Names(unittest.TestCase):
    def test_what_pictures_follow_from(self):
        """A network's picture is another one for other weights or another program; a reference is the same."""
        files = {name: Path(scratch(name)) for name in ("scene.glb", "first", "second", "old", "new")}
        for name, path in files.items():
            path.write_text(name)
            path.chmod(0o755)
        at = variation(files["scene.glb"], 900000, 8)
        old, new = (Renderer(Path(scratch("names")), files[program]) for program in ("old", "new"))
        first, second = (methods.network("n", files[name]).shot(at) for name in ("first", "second"))
        self.assertEqual(len({old.path(first), old.path(second), new.path(first)}), 3)
        truth = methods.references(at, 4)
        self.assertEqual([old.path(shot) for shot in truth], [new.path(shot) for shot in truth])
        self.assertEqual(len({old.path(shot) for shot in (*truth, *methods.references(at, 8))}), 4)

    def test_a_scene_is_also_the_files_that_it_names(self):
        """Or references of before would stand beside pictures of now."""
        scene, beside = Path(scratch("named.gltf")), Path(scratch("my sky.hdr"))
        found = set()
        for uri, content in (("none.bin", ""), ("my%20sky.hdr", "one"), ("my%20sky.hdr", "two")):
            scene.write_text(json.dumps({"images": [{"uri": uri}], "buffers": [{"uri": "data:,x"}]}))
            beside.write_text(content)
            for function in (digest, scene_digest):
                function.cache_clear()
            found.add(scene_digest(scene))
        self.assertEqual(len(found), 3)


class Figures(unittest.TestCase):
    def test_interval(self):
        """Student's t of four values: 3.1824 s / 2."""
        found = figures.summarize([1.0, 2.0, 3.0, None, 6.0])
        self.assertAlmostEqual(found["mean"], 3)
        self.assertAlmostEqual(found["half"], 3.1824 * np.std([1, 2, 3, 6], ddof=1) / 2, places=3)
        self.assertIsNone(figures.summarize([None]))
        self.assertIsNone(figures.summarize([1.0])["half"])

    def test_noise_of_references(self):
        """The RSE of two noisy references has none of their noise; `noise` is what one alone would add."""
        clean = np.float64(radiance(160, 160, 1))
        rng = np.random.default_rng(2)
        noisy = [clean * (1 + 0.05 * rng.standard_normal(clean.shape)) for _ in range(2)]
        write_exr("clean.exr", beauty=np.float32(clean * (1 + 0.02 * rng.standard_normal(clean.shape))))
        truth = Truth(*(write_exr(f"noisy{i}.exr", beauty=np.float32(x)) for i, x in enumerate(noisy)))
        self.assertAlmostEqual(figures.rse(scratch("clean.exr"), truth), 0.02**2, delta=5e-5)
        self.assertAlmostEqual(truth.noise(), 0.05**2, delta=4e-4)


class Time(unittest.TestCase):
    TIMES = {"sample": 40.0, "oidn:high": 100.0}

    def test_paths_that_fit(self):
        self.assertEqual(timing.paths_that_fit(self.TIMES, 120.0), 3)
        self.assertEqual(timing.paths_that_fit(self.TIMES, 119.0), 2)
        self.assertEqual(timing.paths_that_fit(self.TIMES, 10.0), 1)
        self.assertEqual(timing.of_paths(self.TIMES, 3), 120)
        self.assertEqual(timing.of_paths(self.TIMES, 1, "high"), 140)


class Denoiser(unittest.TestCase):
    def test_noise_goes(self):
        """Edges that the guides know stay, noise goes, and metals are not black to it."""
        clean = np.full((64, 64, 3), 0.2)
        clean[:, 32:] = 3
        surface = np.where(clean > 1, 0.9, 0.3)
        path = write_exr(
            "guides.exr", beauty=clean, albedo=np.zeros_like(clean), specular=surface, normal=np.ones_like(clean)
        )
        guide = guides(path)
        np.testing.assert_allclose(guide["albedo"], surface, atol=1e-6)
        noisy = clean * np.random.default_rng(1).exponential(1, clean.shape)
        smooth, seconds = denoise(noisy, guide, "high")
        self.assertLess(np.abs(smooth / clean - 1).mean(), 0.2 * np.abs(noisy / clean - 1).mean())
        self.assertGreater(seconds, 0)


class Flicker(unittest.TestCase):
    def test_sequence(self):
        """A method's steady error has the reference's own change; noise that differs from frame to frame has more."""
        base, still, rng = np.float64(radiance(40, 40, 9)), np.zeros((40, 40), np.float32), np.random.default_rng(3)
        names = {"truth": 0.0, "steady": 0.3, "noisy": 0.3}
        files = {name: [] for name in names}
        for n in range(4):
            for name, error in names.items():
                noise = rng.uniform(-error, error, base.shape) if name == "noisy" else error
                files[name].append(
                    write_exr(f"{name}{n}.exr", beauty=base * (1 + 0.1 * n) + noise, motion__X=still, motion__Y=still)
                )
        truth, steady, noisy = (sequence.of_pictures(files[name], files["truth"]) for name in names)
        self.assertAlmostEqual(steady["change"]["mean"], truth["change"]["mean"], places=5)
        self.assertAlmostEqual(steady["temporal_error"]["mean"], 0, places=5)
        self.assertGreater(noisy["change"]["mean"], 1.1 * truth["change"]["mean"])
        self.assertGreater(noisy["temporal_error"]["mean"], 0.05)
