"""Programs that break the contract are refused; presets keep it; files hold what was put into them."""

import os
import subprocess
import unittest
from pathlib import Path

import numpy as np
import torch
from made import ROOT

from lightformer_train import families, network_file, program, weights

OUTPUTS = [{"op": "mul", "in": ["pixel.diffuse", "frame.radiance"], "out": name} for name in program.OUTPUTS]


def refusal(*operations: dict) -> str:
    """What the check says of these, in front of valid outputs."""
    try:
        program.check([*operations, *OUTPUTS])
    except program.ProgramError as error:
        return str(error)
    return ""


def linear(*inputs: str, out: str = "x", **parameters: object) -> dict:
    return {"op": "linear", "in": list(inputs), "out": out, "name": out, "channels": 4, **parameters}


class Checks(unittest.TestCase):
    def test_what_is_wrong_is_said(self):
        cases = {
            "unknown operation": {"op": "invert", "in": ["pixel.normal"], "out": "x"},
            "not written before": linear("y"),
            'no parameter "size"': linear("pixel.normal", size=3),
            'parameter "channels" is missing': {"op": "linear", "in": ["pixel.normal"], "out": "x", "name": "x"},
            "must be of type int": linear("pixel.normal", channels=4.5),
            "unknown activation": linear("pixel.normal", act="swish"),
            "do not meet": linear("vpl.normal", "pixel.normal"),
            "a picture is needed": {"op": "pool", "in": ["light.color"], "out": "x"},
            "channels 2 to 5 of 3": {"op": "slice", "in": ["pixel.normal"], "out": "x", "from": 2, "to": 5},
            "it reads 1 values": {"op": "add", "in": ["pixel.normal"], "out": "x"},
            "rows are needed": {"op": "mean", "in": ["pixel.normal"], "out": "x"},
            "nothing is finer": {"op": "up", "in": ["pixel.normal"], "out": "x"},
            "a value of a light": {"op": "sum", "in": ["pixel.normal"], "out": "x"},
            "one number a light": {"op": "sum", "in": ["view.diffuse", "light.color"], "out": "x"},
            "what only the gather knows": linear("texel.flux", "light.share"),
            "a name of its own": linear("pixel.normal", out="pixel.mask"),
        }
        for message, operation in cases.items():
            with self.subTest(message):
                self.assertIn(message, refusal(operation))
        self.assertEqual(refusal(linear("pixel.normal")), "")

    def test_levels_must_meet(self):
        pool = {"op": "pool", "in": ["pixel.normal"], "out": "p"}
        self.assertIn("levels [0, 1]", refusal(pool, linear("p", "pixel.normal")))

    def test_a_missing_output_is_named(self):
        with self.assertRaisesRegex(program.ProgramError, '"unshadowed"'):
            program.check(OUTPUTS[1:])

    def test_what_depends_on_the_gather_belongs_to_it(self):
        checked = program.check(
            [
                linear("view.direction", out="a"),
                {"op": "sum", "in": ["a"], "out": "b"},
                linear("b", "view.direction", out="c"),
                *OUTPUTS,
            ]
        )
        self.assertEqual([checked.values[name].gather for name in "abc"], [False, True, True])

    def test_a_narrower_domain_is_counted_once(self):
        cost = program.cost(program.check([linear("pixel.normal", "view.direction", "light.color"), *OUTPUTS]))
        self.assertEqual((cost.pixel, cost.view, cost.light), (12, 12, 12))


class Presets(unittest.TestCase):
    def test_every_preset_and_every_part_left_out_is_a_program(self):
        for preset in families.PRESETS:
            whole = families.build(preset)
            program.check(whole)
            for part in families.parts(preset):
                with self.subTest(preset=preset, without=part):
                    less = families.build(preset, frozenset([part]))
                    program.check(less)
                    self.assertNotEqual(less, whole)

    def test_encodings_do_not_read_powers(self):
        checked = program.check(families.build("structured-small"))
        for name in checked.inputs:
            if program.INPUTS[name].gather:
                readers = [o for o in checked.operations if name in o["in"]]
                self.assertTrue(all(checked.values[o["out"]].gather for o in readers), name)

    def test_structured_knows_no_absolute_place_and_no_power(self):
        absolute = {"pixel.position", "vpl.position", "texel.position", "light.power", "frame.mean_power"}
        for preset in ("structured-small", "structured"):
            self.assertFalse(absolute & set(program.check(families.build(preset)).inputs))

    def test_lean_knows_no_length_and_no_direction(self):
        """Vectors meet in products alone, which turn with nothing."""
        checked = program.check(families.build("lean"))
        vectors = {name for name in checked.inputs if name.endswith((".position", ".normal", ".view", ".direction"))}
        self.assertEqual(vectors, {"pixel.normal", "pixel.view"})
        for operation in checked.operations:
            if vectors & set(operation["in"]):
                self.assertEqual(operation["op"], "dot")
        self.assertFalse({"pixel.distance", "view.distance", "view.occluder"} & set(checked.inputs))

    def test_presets_for_cpus_are_small(self):
        for preset, most in (("lean", 5_000), ("structured-small", 50_000)):
            cost = program.cost(program.check(families.build(preset)))
            self.assertLess(cost.per_pixel(3), most)

    def test_unknown_parts_are_named(self):
        with self.assertRaisesRegex(ValueError, 'no part "ears"'):
            families.build("paper", frozenset(["ears"]))


class Command(unittest.TestCase):
    def test_errors_are_one_line(self):
        command = [str(ROOT / "tools/train/program.py"), "structured-small"]
        for arguments, status, word in (
            (["--seed", "-1"], 2, "--seed"),
            (["--without", "ears"], 2, "ears"),
            (["-o", "/dev/full/x"], 1, "/dev/full/x: cannot be written"),
            (["-o", "/dev"], 1, "/dev: cannot be written"),
        ):
            with self.subTest(word):
                done = subprocess.run([*command, *arguments], capture_output=True, text=True, check=False)
                self.assertEqual((done.returncode, done.stderr.count("\n")), (status, 1), done.stderr)
                self.assertIn(word, done.stderr)


class Files(unittest.TestCase):
    def setUp(self):
        self.path = Path(os.environ["NG_TEST_DIR"]) / "network.safetensors"
        torch.manual_seed(3)
        self.network = network_file.create("structured-small")
        notes = network_file.Description("structured-small", quality={"rse": {"total": 0.5}}).notes()
        network_file.save(self.path, self.network, notes)

    def test_a_network_comes_back(self):
        again, notes = network_file.load(self.path)
        self.assertEqual(notes["preset"], "structured-small")
        self.assertEqual(again.checked.operations, self.network.checked.operations)
        for name, value in self.network.tensors().items():
            self.assertTrue(torch.equal(value, again.tensors()[name]), name)

    def test_damage_is_found(self):
        data = bytearray(self.path.read_bytes())
        data[-5] ^= 1
        self.path.write_bytes(data)
        with self.assertRaisesRegex(weights.FileError, "damaged"):
            network_file.load(self.path)

    def test_files_that_are_none(self):
        data = self.path.read_bytes()
        for name, content in {"empty": b"", "short": data[:7], "cut": data[:1000], "long": b"\xff" * 64}.items():
            with self.subTest(name):
                self.path.write_bytes(content)
                with self.assertRaises(weights.FileError):
                    network_file.load(self.path)

    def test_weights_that_do_not_fit(self):
        tensors, notes = weights.read(self.path)
        del tensors["z_i.bias"]
        weights.write(self.path, tensors, {name: text for name, text in notes.items() if name != "hash"})
        with self.assertRaisesRegex(weights.FileError, "network.safetensors"):
            network_file.load(self.path)

    def test_wide_elements_come_first(self):
        weights.write(self.path, {"a": np.zeros(3, np.uint8), "b": np.ones((2, 2), np.float32)}, {"key": "ü"})
        tensors, notes = weights.read(self.path)
        header, _, begin = weights.read_header(self.path)
        self.assertEqual((header["b"]["data_offsets"], begin % 8, notes["key"]), ([0, 16], 0, "ü"))
        self.assertTrue(np.array_equal(tensors["b"], np.ones((2, 2))))
