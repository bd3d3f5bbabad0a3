"""A training in seconds: the loss falls, repeating gives the same bytes, a resumed run equals an uninterrupted one."""

import io
import json
import math
import os
import resource
import shlex
import shutil
import signal
import socket
import struct
import subprocess
import sys
import unittest
from contextlib import redirect_stdout
from dataclasses import replace
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import torch
from made import ROOT, dataset
from made import SETTINGS as SETTINGS_OF_DATA

from lightformer_train import data, families, manifest, training, weights
from lightformer_train.data import Dataset, Options
from lightformer_train.outputs import read_checkpoint
from lightformer_train.program import INPUTS, INPUTS_VERSION
from lightformer_train.training import Settings, Stopped, Trainer

SCRATCH = Path(os.environ["NG_TEST_DIR"])
SETTINGS = Settings("structured-small", steps=70, batch=2, held_out=4, threads=1)


def trainer(name: str, **changes: object) -> Trainer:
    settings = Settings(**{**vars(SETTINGS), **changes})
    return Trainer(settings, Dataset([SCRATCH / "data"]), SCRATCH / f"{name}.safetensors", ROOT)


def run(*arguments: str) -> subprocess.CompletedProcess:
    command = [str(ROOT / "tools/train/train.py"), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def free_port() -> str:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return str(probe.getsockname()[1])


def start_group(*commands: list[str]) -> list[subprocess.Popen]:
    """The processes of one training, as torchrun starts them."""
    count = str(len(commands))
    shared = {"WORLD_SIZE": count, "LOCAL_WORLD_SIZE": count, "MASTER_ADDR": "127.0.0.1", "MASTER_PORT": free_port()}
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return [
        subprocess.Popen(command, env=os.environ | shared | {"RANK": str(rank), "LOCAL_RANK": str(rank)}, **pipes)
        for rank, command in enumerate(commands)
    ]


def setUpModule() -> None:
    shutil.rmtree(SCRATCH, ignore_errors=True)  # of a run before
    SCRATCH.mkdir(parents=True)
    dataset(SCRATCH / "data")


class Training(unittest.TestCase):
    def test_it_learns_and_repeats_and_resumes(self):
        whole = trainer("whole")
        whole.run()
        first, last = (sum(curve[i][1] for curve in whole.history.loss.values()) for i in (0, -1))
        self.assertLess(last, 0.7 * first)
        _, notes = weights.read(SCRATCH / "whole.safetensors")
        self.assertIn("--steps 70", notes["training"])
        self.assertEqual(notes["dataset"], Dataset([SCRATCH / "data"]).hash)
        judged = json.loads(notes["quality"])
        self.assertEqual(set(judged["rse"]), {"unshadowed", "direct", "indirect", "total"})
        self.assertEqual((judged["crops"], judged["samples_per_pixel"]), (4, 8))
        made_by = "lightformer dataset made.glb -o data --seed 0 --count 12 --size 24 --crop 24 --crops 2 --spp 8"
        self.assertEqual(notes["data"], f"{made_by} --depth 0 --vpls 24 --time 0 --shard 24")
        command = [os.environ["LIGHTFORMER"], "net", str(SCRATCH / "whole.safetensors")]
        shown = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        for name in ("training", "data", "quality"):
            self.assertIn(notes[name], shown)
        page = (SCRATCH / "whole.html").read_text(encoding="utf-8")
        self.assertIn("polyline", page)
        self.assertIn("data:image/png", page)

        interrupted = trainer("parts")
        interrupted._decide_total = lambda: interrupted.step == 31 and os.kill(os.getpid(), signal.SIGINT)
        with self.assertRaisesRegex(Stopped, "interrupted at step 31"):
            interrupted.run()
        resumed = trainer("parts")
        resumed.resume()
        self.assertEqual(resumed.step, 31)
        resumed.run()
        self.assertFalse((SCRATCH / "parts.checkpoint").exists())
        same = [(SCRATCH / f"{name}.safetensors").read_bytes() for name in ("whole", "parts")]
        self.assertEqual(same[0], same[1])

    def test_minutes_become_steps(self):
        short = trainer("minutes", steps=0, minutes=1e-6)
        short.run()
        self.assertEqual(short.step, training.WARM_UP + 2)

    def test_a_resumed_training_keeps_its_length(self):
        trainer("length")._save_checkpoint()
        with self.assertRaisesRegex(Stopped, "of 70 steps, not 71"):
            trainer("length", steps=71).resume()
        by_minutes = trainer("length", steps=0)  # what was decided counts
        by_minutes.resume()
        self.assertEqual(by_minutes.total, 70)

    def test_minutes_become_steps_after_an_early_interruption(self):
        early = trainer("early", steps=0, minutes=1e-6)
        early.step = training.WARM_UP - 1
        early._save_checkpoint()
        resumed = trainer("early", steps=0, minutes=1e-6)
        resumed.resume()
        resumed.run()
        self.assertEqual(resumed.step, training.WARM_UP + 2)

    def test_what_is_not_a_number_is_not_written(self):
        """A judgement, weights at a checkpoint, a loss."""
        far = trainer("far", steps=1, rate=1e8)
        with self.assertRaisesRegex(Stopped, "not numbers; lower --rate"):
            far.run()
        broken = trainer("far")
        broken.network.parameter.data[0] = math.nan
        with self.assertRaisesRegex(Stopped, "not numbers; lower --rate"):
            broken._save_checkpoint()
        with self.assertRaisesRegex(Stopped, "loss of step 0 is not a number; lower --rate, or look for damage"):
            broken.run()
        self.assertFalse((SCRATCH / "far.safetensors").exists() or (SCRATCH / "far.html").exists())

    def test_a_checkpoint_of_other_settings_is_refused(self):
        one = trainer("other")
        one._save_checkpoint()
        with self.assertRaisesRegex(Stopped, "other settings"):
            trainer("other", batch=3).resume()

    def test_a_damaged_checkpoint_is_refused(self):
        """Wherever the damage is, among what says which objects follow as well."""
        damaged = trainer("damaged")
        damaged._save_checkpoint()
        path = SCRATCH / "damaged.checkpoint"
        whole = path.read_bytes()
        places = [
            whole.index(text) + i for text in (b"identity", b"structured-small", b"OrderedDict") for i in range(3)
        ]
        for place in (0, *places, len(whole) // 2, len(whole) - 30):
            spoilt = bytearray(whole)
            spoilt[place] ^= 0xC5
            path.write_bytes(spoilt)
            with self.subTest(place=place), self.assertRaisesRegex(Stopped, "not a checkpoint, or damaged"):
                damaged.resume()
        for text in (b"", b"no", whole[:1000]):
            path.write_bytes(text)
            with self.assertRaisesRegex(Stopped, "not a checkpoint, or damaged"):
                damaged.resume()
        path.write_bytes(whole)
        with ZipFile(path) as archive:  # a whole file whose objects cannot be made
            name = next(name for name in archive.namelist() if name.endswith("data.pkl"))
            content = {entry: archive.read(entry) for entry in archive.namelist()}
        for wrong in (b"\x80\x02X\x04\x00\x00\x00\xff\xff\xff\xff.", b"\x80\x02cos\nnothing_like_it\n.", b"\x80\x02]."):
            with ZipFile(path, "w") as archive:
                for entry, text in (content | {name: wrong}).items():
                    archive.writestr(entry, text)
            with self.subTest(wrong=wrong), self.assertRaisesRegex(Stopped, "not a checkpoint, or damaged"):
                damaged.resume()

    def test_where_nothing_can_be_written_is_known_before_the_first_step(self):
        folder = SCRATCH / "folder.safetensors"
        folder.mkdir(exist_ok=True)
        for name, beside in (("folder", ""), ("missing/x", ""), ("blocked", ".checkpoint"), ("blocked", ".html")):
            taken = SCRATCH / f"blocked{beside}"
            if beside:
                taken.mkdir()
            with self.subTest(name, beside=beside), self.assertRaisesRegex(weights.FileError, f"{name}{beside}"):
                trainer(name)
            if beside:
                taken.rmdir()
        with self.assertRaisesRegex(Stopped, "beside the network"):
            Trainer(SETTINGS, Dataset([SCRATCH / "data"]), SCRATCH / "same.html", ROOT)
        limits = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limits[1]))  # the system refuses as it does on a full disk
        try:
            with self.assertRaisesRegex(weights.FileError, "full.safetensors: cannot be written"):
                trainer("full")
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        self.assertEqual([path.name for path in SCRATCH.glob("*.part")], [])

    def test_what_fails_at_the_end_goes_on_from_there(self):
        late = trainer("late", steps=3)
        late._decide_total = lambda: late.output.mkdir(exist_ok=True)
        with self.assertRaisesRegex(weights.FileError, "late.safetensors: cannot be written"):
            late.run()
        late.output.rmdir()
        again = trainer("late", steps=3)
        again.resume()
        self.assertEqual(again.step, 3)
        again.run()
        trainer("early", steps=3).run()
        same = [(SCRATCH / f"{name}.safetensors").read_bytes() for name in ("late", "early")]
        self.assertEqual(same[0], same[1])

    def test_the_recorded_command_gives_the_same_bytes(self):
        """Pasted in a folder where the data are, whatever the places and the output were called."""
        trainer("recorded", steps=2, held_out=1000).run()
        recorded = (SCRATCH / "recorded.safetensors").read_bytes()
        words = shlex.split(weights.read(SCRATCH / "recorded.safetensors")[1]["training"])
        elsewhere = SCRATCH / "elsewhere"
        dataset(elsewhere / "data")
        subprocess.run([str(ROOT / words[0]), *words[1:]], cwd=elsewhere, check=True, stdout=subprocess.DEVNULL)
        self.assertEqual((elsewhere / "OUT.safetensors").read_bytes(), recorded)

    def test_at_most_half_is_held_out_and_it_is_said(self):
        said = io.StringIO()
        with redirect_stdout(said):
            many = trainer("many", held_out=1000)
        self.assertEqual(said.getvalue(), "12 of 24 crops are held out, not 1000: at most half are\n")
        self.assertEqual((len(many.learn), len(many.test)), (12, 12))
        self.assertIn("--held-out 12", many.settings.command([], 1))
        single = Dataset([dataset(SCRATCH / "single", samples=1)])
        with self.assertRaisesRegex(Stopped, "two samples"):
            Trainer(SETTINGS, single, SCRATCH / "single.safetensors", ROOT)

    def test_the_noisiest_data_set_is_named(self):
        noisy = dataset(SCRATCH / "noisy", spp=2)
        both = Trainer(
            replace(SETTINGS, steps=1), Dataset([SCRATCH / "data", noisy]), SCRATCH / "both.safetensors", ROOT
        )
        both.run()
        _, notes = weights.read(SCRATCH / "both.safetensors")
        self.assertEqual(json.loads(notes["quality"])["samples_per_pixel"], 2)
        self.assertRegex(notes["data"], "-o data .* --spp 8 .* && lightformer dataset made.glb -o noisy .* --spp 2 ")


class Manifests(unittest.TestCase):
    def command(self, *shards: tuple[int, int], **settings: str) -> str:
        """Of shards with so many samples from a seed."""
        folder = SCRATCH / "listed"
        folder.mkdir(exist_ok=True)
        content = {
            "settings": SETTINGS_OF_DATA | {"size": "64", "crop": "32", "crops": "4", "spp": "1"} | settings,
            "shards": [{"file": "x", "first_seed": first, "samples": samples} for first, samples in shards],
        }
        (folder / "manifest.json").write_text(json.dumps(content))
        return manifest.read(folder).command()

    def test_shards_are_cut_as_they_were(self):
        for shards, size in (
            ([(0, 16), (16, 16), (32, 3)], 16),
            ([(5, 3), (8, 2)], 4),
            ([(7, 1), (8, 8), (16, 2)], 8),
            ([(900001, 2)], 3),
        ):
            with self.subTest(shards=shards):
                self.assertIn(f"--shard {4 * size}", self.command(*shards))

    def test_gaps_are_ranges_of_their_own(self):
        first, second = self.command((8, 8), (0, 8), (32, 8)).split(" && ")
        self.assertIn("--seed 0 --count 16 ", first)
        self.assertIn("--seed 32 --count 8 ", second)

    def test_a_camera_is_named_where_one_was(self):
        self.assertIn("--camera 'the left one'", self.command((0, 1), camera="the left one"))
        self.assertNotIn("--camera", self.command((0, 1)))

    def test_what_is_none_is_refused(self):
        for wrong in ({"spp": "many"}, {"spp": "0"}):
            with self.assertRaisesRegex(weights.FileError, "not the manifest"):
                self.command((0, 1), **wrong)
        with self.assertRaisesRegex(weights.FileError, "not the manifest"):
            self.command((0, 0))


class Data(unittest.TestCase):
    def setUp(self):
        self.dataset = Dataset([SCRATCH / "data"])

    def batch(self, seed: int, **options: object) -> data.Batch:
        return self.dataset.batch(self.dataset.crops[:3], Options(**options), np.random.default_rng(seed))

    def test_held_out_samples_are_not_learned_from(self):
        learn, test = self.dataset.split(4)
        self.assertEqual((len(learn), len(test)), (20, 4))
        self.assertFalse({crop.seed for crop in learn} & {crop.seed for crop in test})
        self.assertTrue(self.dataset.split(1)[1])

    def test_a_sample_of_two_data_sets_is_on_one_side(self):
        again = dataset(SCRATCH / "again", samples=8, spp=2)
        for folders in ([SCRATCH / "data"] * 2, [SCRATCH / "data", again]):
            both = Dataset(folders)
            for held_out in (1, 4, 7, 20):
                learn, test = both.split(held_out)
                self.assertTrue(learn and test)
                self.assertFalse({crop.seed for crop in learn} & {crop.seed for crop in test})
        other = dataset(SCRATCH / "other", samples=8, spp=2, scene="other.glb")
        learn, test = Dataset([SCRATCH / "data", other]).split(14)
        self.assertEqual((len(learn), len(test)), (26, 14))
        self.assertTrue({crop.seed for crop in learn} & {crop.seed for crop in test})  # of another scene

    def test_the_split_of_one_data_set_stays(self):
        """Held-out crops of a resumed or repeated training were not learned from."""
        self.assertEqual([crop.seed for crop in self.dataset.split(4)[1][::2]], [5, 11])
        self.assertEqual([crop.seed for crop in self.dataset.split(8)[1][::2]], [2, 5, 8, 11])

    def test_plain_batches_hold_what_the_shard_holds(self):
        batch = self.batch(0, augment=False, mirror_dropout=0, vpls=500, texels=500)
        stored = self.dataset.shards[0]["1/view.glossy"][0].astype(np.float32)
        self.assertTrue(np.array_equal(batch.inputs["view.glossy"][4:6].numpy(), stored))
        self.assertEqual(batch.lights.owner.tolist(), [0, 0, 1, 1, 2, 2])
        stored = self.dataset.shards[0]["1/texel.flux"][0]
        self.assertTrue(np.array_equal(batch.inputs["texel.flux"][4, :, :48, 0].numpy(), stored))
        self.assertEqual(batch.lights.rows["texel"].sum(2).flatten().tolist(), [48] * 6)

    def test_symmetries_keep_lengths_angles_and_brightness(self):
        plain = self.batch(0, augment=False, mirror_dropout=0)
        for seed in range(6):
            turned = self.batch(seed, mirror_dropout=0)
            for before, after in zip(self.invariants(plain), self.invariants(turned)):
                for a, b in zip(before, after):  # each crop is flipped or not
                    self.assertTrue(any(np.allclose(a, x, atol=1e-5) for x in (b, b.flip(-1))))

    @staticmethod
    def invariants(batch: data.Batch) -> list:
        normal, direction = batch.inputs["pixel.normal"], batch.inputs["view.direction"]
        return [
            (normal * batch.inputs["pixel.view"]).sum(1),
            (normal[batch.lights.owner] * direction).sum(1),
            batch.inputs["view.diffuse"].sum(1),
            batch.indirect.sum(1),
        ]

    def test_chosen_rows_are_right_on_average(self):
        whole = self.batch(0, augment=False, texels=48).inputs["texel.flux"].mean(2)
        few = [self.batch(seed, augment=False, texels=12).inputs["texel.flux"] for seed in range(200)]
        self.assertEqual(few[0].shape[2], 12)
        mean = sum(x.mean(2) for x in few) / len(few)
        self.assertLess(float((mean - whole).abs().max()), 0.03)

    def test_the_mirror_clue_is_missing_at_times(self):
        batch = self.batch(0, mirror_dropout=1.0)
        for name in INPUTS:
            if "mirror" in name:
                self.assertEqual(float(batch.inputs[name].abs().max()), 0, name)


class Radii(unittest.TestCase):
    """A scene of twice the radius has other units and the same light."""

    # Depends on where the RSM's rays are, which its random numbers and rounding decide.
    SAMPLED = {"texel", "bounce", "gathered", "mirror", "mirror_light", "mirror_albedo", "glossy_reached", "occluder"}

    @staticmethod
    def inputs(name: str, times: float) -> dict[str, torch.Tensor]:
        """Of a frame of Chess with so many times its radius."""
        glb = (ROOT / "content/chess/chess.glb").read_bytes()
        (length,) = struct.unpack_from("<I", glb, 12)
        content = json.loads(glb[20 : 20 + length])
        content["scenes"][0]["extensions"]["NG_scene"]["components"]["scene_scale"]["radius"] *= times
        text = json.dumps(content).encode()
        text += b" " * (-len(text) % 4)
        size = len(glb) - length + len(text)
        scene, folder = SCRATCH / f"{name}.glb", SCRATCH / name
        scene.write_bytes(glb[:8] + struct.pack("<II", size, len(text)) + glb[16:20] + text + glb[20 + length :])
        command = [os.environ["LIGHTFORMER"], "dataset", str(scene), "-o", str(folder)]
        options = "--count 1 --size 48 --crop 0 --crops 1 --spp 1 --seed 5".split()
        subprocess.run([*command, *options], check=True, stdout=subprocess.DEVNULL)
        tensors, _ = weights.map_tensors(next(folder.glob("*.safetensors")))
        return {input: torch.from_numpy(tensors[f"5/{input}"].copy()).float() for input in INPUTS}

    def test_units_are_what_differs(self):
        for name, times in (("once", 1.0), ("twice", 2.0)):
            shutil.rmtree(SCRATCH / name, ignore_errors=True)
            found = self.inputs(name, times)
            data._divide_radius(found, times)
            one = found if times == 1 else one
        for name in INPUTS:
            expected, error = one[name], (found[name] - one[name]).square().sum()
            sampled = bool(set(name.split(".")) & self.SAMPLED) or name == "pixel.mirror"
            with self.subTest(name):
                self.assertLessEqual(float(error), (3e-2 if sampled else 1e-3) * float(expected.square().sum()))

    def test_targets_stay_and_the_default_draws_nothing(self):
        whole = Dataset([SCRATCH / "data"])
        crops = whole.crops[:6:2]
        kinds = {f"{crop.seed}/light.kind": np.float32([[1, 0, 0], [0, 1, 0]]) for crop in crops}
        kinds[f"{crops[2].seed}/light.kind"] = np.float32([[0, 0, 1], [0, 1, 0]])  # one is at infinity
        whole.shards[0] = whole.shards[0] | kinds
        exact = Options(augment=False, mirror_dropout=0, vpls=24, texels=48)
        plain, other = (
            whole.batch(crops, replace(exact, radii=radii), np.random.default_rng(3)) for radii in (1.0, 4.0)
        )
        for name in ("unshadowed", "direct", "indirect", "unit"):
            self.assertTrue(torch.equal(getattr(plain, name), getattr(other, name)))
        self.assertTrue(torch.equal(plain.inputs["frame.radiance"], other.inputs["frame.radiance"]))
        ratio = other.inputs["frame.mean_power"] / plain.inputs["frame.mean_power"]
        self.assertTrue(((ratio > 1 / 16) & (ratio < 16)).all())
        self.assertEqual([float(x) == 1 for x in ratio], [False, False, True])
        self.assertTrue(torch.equal(plain.unit, plain.inputs["frame.radiance"]))


class Commands(unittest.TestCase):
    def test_errors_are_one_line(self):
        shardless = SCRATCH / "shardless"
        shardless.mkdir(exist_ok=True)
        manifest_text = (SCRATCH / "data/manifest.json").read_text()
        file = json.loads(manifest_text)["shards"][0]["file"]
        (shardless / "manifest.json").write_text(manifest_text.replace(file, "shard.safetensors"))
        output = SCRATCH / "x.safetensors"
        parts = ", ".join(families.parts("lean"))
        cases = {
            (SCRATCH / "nowhere",): (1, f"{SCRATCH}/nowhere/manifest.json: there is none"),
            (shardless,): (1, f"{shardless}/shard.safetensors: there is none"),
            (SCRATCH / "data", "--resume"): (1, f"{SCRATCH}/x.checkpoint: there is none"),
            (SCRATCH / "data", "--without", "ears"): (2, f'lean has no part "ears"; it has {parts}'),
        }
        for (folder, *options), (status, line) in cases.items():
            with self.subTest(line):
                done = run(str(folder), "-o", str(output), *options)
                self.assertEqual((done.returncode, done.stderr), (status, f"train: {line}\n"))

    def test_bad_options_are_one_line(self):
        cases = (("--seed", "-1"), ("--threads", "-3"), ("--steps", "0"), ("--rate", "nan"))
        for option, value in (*cases, ("--minutes", "soon"), ("--batch", "1.5")):
            with self.subTest(option=option, value=value):
                done = run(str(SCRATCH / "data"), "-o", str(SCRATCH / "x.safetensors"), option, value)
                self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
                self.assertIn(f"argument {option}", done.stderr)
                self.assertIn(repr(value), done.stderr)

    def test_a_killed_process_leaves_a_checkpoint(self):
        """The second is killed after its third step; the first says so, and goes on from there when it is asked to."""
        output = SCRATCH / "killed.safetensors"
        arguments = [str(SCRATCH / "data"), "-o", str(output), "--steps", "6", "--batch", "1", "--held-out", "4"]
        arguments += ["--threads", "1", "--processes", "2"]
        mortal = (
            "import os, runpy, signal; from lightformer_train.training import Trainer; "
            "Trainer._note = lambda self: self.step == 3 and os.kill(os.getpid(), signal.SIGKILL); "
            f"runpy.run_path({str(ROOT / 'tools/train/train.py')!r}, run_name='__main__')"
        )
        both = start_group([str(ROOT / "tools/train/train.py"), *arguments], [sys.executable, "-c", mortal, *arguments])
        said = [process.communicate()[1] for process in both][0]
        self.assertEqual([process.returncode for process in both], [1, -signal.SIGKILL], said)
        self.assertEqual(said, "train: another process of the training has ended at step 3; --resume goes on\n")
        self.assertEqual(read_checkpoint(output.with_suffix(".checkpoint"), torch.device("cpu"))["step"], 3)
        whole = output.with_name("unkilled.safetensors")
        for done in (
            run(*arguments, "--resume"),
            run(*(str(whole) if word == str(output) else word for word in arguments)),
        ):
            self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(output.read_bytes(), whole.read_bytes())

    def test_two_processes_train_one_network(self):
        """As torchrun starts them; only the first writes."""
        output = SCRATCH / "two.safetensors"
        arguments = (str(SCRATCH / "data"), "-o", str(output), "--steps", "4", "--batch", "1", "--held-out", "4")
        command = [str(ROOT / "tools/train/train.py"), *arguments, "--threads", "1"]
        both = start_group(command, command)
        said = [process.communicate()[0] for process in both]
        self.assertEqual([process.returncode for process in both], [0, 0])
        self.assertIn("step 4", said[0])
        self.assertEqual(said[1], "")
        self.assertTrue(output.exists())
        started = output.with_name("started.safetensors")  # the same, by one command
        done = run(*(str(started) if word == str(output) else word for word in command[1:]), "--processes", "2")
        self.assertEqual(done.returncode, 0, done.stderr)
        ours, theirs = (weights.read(path)[0] for path in (started, output))
        for name, value in theirs.items():
            np.testing.assert_array_equal(ours[name], value)

    def test_all_processes_end_with_the_first(self):
        arguments = (str(SCRATCH / "nowhere"), "-o", str(SCRATCH / "x.safetensors"), "--processes", "2")
        done = run(*arguments)
        self.assertEqual(done.returncode, 1)
        self.assertEqual(done.stderr.count("\n"), 1)

    def test_a_data_set_without_inputs_is_refused(self):
        tensors, _ = weights.map_tensors(next((SCRATCH / "data").glob("*.safetensors")))
        folder = SCRATCH / "old"
        folder.mkdir(exist_ok=True)
        kept = {name: x for name, x in tensors.items() if "view.bounce" not in name}
        weights.write(folder / "shard.safetensors", kept, {})
        for version, expected in ((INPUTS_VERSION, "view.bounce"), ("1", "version 1, not")):
            content = json.loads((SCRATCH / "data/manifest.json").read_text())
            content["settings"]["format"] = version
            content["shards"][0]["file"] = "shard.safetensors"
            (folder / "manifest.json").write_text(json.dumps(content))
            with self.assertRaisesRegex(weights.FileError, expected):
                Dataset([folder])
