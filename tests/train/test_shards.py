"""Data sets that are not what they should be: train.py names the file in one line and exits with 1."""

import json
import os
import shutil
import unittest
from collections.abc import Callable
from pathlib import Path

import numpy as np
from made import dataset, train

from lightformer_train import weights
from lightformer_train.program import INPUTS_VERSION

SCRATCH = Path(os.environ["NG_TEST_DIR"])
WHOLE = SCRATCH / "whole"

Arrays = dict[str, np.ndarray]


def setUpModule() -> None:
    shutil.rmtree(SCRATCH, ignore_errors=True)  # of a run before
    SCRATCH.mkdir(parents=True)
    dataset(WHOLE, samples=3, crops=2)


def shard_of(folder: Path) -> Path:
    return next(folder.glob("shard-*"))


def spoilt(change: Callable[[Arrays, dict[str, str]], None]) -> Path:
    """The data set with another shard."""
    folder = SCRATCH / "spoilt"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(WHOLE, folder)
    tensors, notes = weights.map_tensors(shard_of(WHOLE))
    del notes["hash"]
    arrays = {name: array.copy() for name, array in tensors.items()}
    change(arrays, notes)
    weights.write(shard_of(folder), arrays, notes)
    return folder


def replaced(name: str, by: Callable[[np.ndarray], np.ndarray]) -> Callable[[Arrays, dict[str, str]], None]:
    """Of the second sample."""
    return lambda arrays, _: arrays.update({f"1/{name}": by(arrays[f"1/{name}"])})


def with_number(name: str, value: float) -> Callable[[Arrays, dict[str, str]], None]:
    """One of many."""

    def put(array: np.ndarray) -> np.ndarray:
        array.flat[array.size // 3] = value
        return array

    return replaced(name, put)


def renamed(arrays: Arrays, _: dict[str, str]) -> None:
    for name in [name for name in arrays if name.startswith("1/")]:
        arrays["8" + name[1:]] = arrays.pop(name)


class Refused(unittest.TestCase):
    def refused(self, folder: Path | str, expected: str, *more: object) -> None:
        output = SCRATCH / "x.safetensors"
        reads_most = "--preset", "structured-small"
        status, _, errors = train(folder, *more, "-o", output, "--steps", "1", "--threads", "1", *reads_most)
        self.assertEqual((status, errors.count("\n")), (1, 1), errors)
        self.assertTrue(errors.startswith("train: ") and expected in errors, errors)
        self.assertFalse(any(SCRATCH.glob("x.*")))

    def test_other_shapes_and_types(self):
        for name, by, expected in (
            ("pixel.normal", lambda x: x[:, :2], "is 2 x 2 x 24 x 24 numbers, not 2 x 3 x 24 x 24"),
            ("pixel.normal", lambda x: x[..., :12], "2 x 3 x 24 x 12 numbers"),
            ("view.bounce", lambda x: x[:1], "1 x 2 x 3 x 24 x 24 numbers, not 2 x 2"),
            ("view.distance", lambda x: x[:, :1], "2 x 1 x 1 x 24 x 24 numbers, not 2 x 2"),
            ("light.share", lambda x: x[:1], "1 x 1 numbers, not 2 x 1"),
            ("vpl.power", lambda x: x[..., :7], "2 x 3 x 7 numbers, not 2 x 3 x 24"),
            ("texel.flux", lambda x: x[..., :7], "texel.normal: 2 x 3 x 48 numbers, not 2 x 3 x 7"),
            ("frame.radiance", lambda x: x[None], "1 x 1 numbers, not 1"),
            ("target.indirect", lambda x: x[0], "3 x 24 x 24 numbers"),
            ("target.shadow", np.uint8, "numbers of type uint8"),
            ("pixel.diffuse", np.int32, "numbers of type int32"),
        ):
            with self.subTest(name, expected=expected):
                self.refused(spoilt(replaced(name, by)), expected.removeprefix("is "))
        self.refused(spoilt(replaced("pixel.normal", lambda x: x[:, :2])), "spoilt/shard-0000000000-0000000002.safet")

    def test_lights_without_rows(self):
        def change(arrays: Arrays, _: dict[str, str]) -> None:
            for name in [name for name in arrays if name.startswith("1/vpl")]:
                arrays[name] = arrays[name][..., :0]

        self.refused(spoilt(change), "sample 1, vpl.")

    def test_what_is_not_a_number(self):
        for name, value in (("view.glossy", np.nan), ("light.color", np.nan), ("target.indirect", np.inf)):
            with self.subTest(name):
                expected = f"spoilt/shard-0000000000-0000000002.safetensors: sample 1, {name}: has values that are"
                self.refused(spoilt(with_number(name, value)), expected)

    def test_other_samples_and_settings(self):
        self.refused(spoilt(lambda arrays, _: arrays.pop("2/light.kind")), "sample 2 has no light.kind")
        self.refused(spoilt(renamed), "holds other samples")
        for key, value in (("format", "5"), ("scene", "other.glb"), ("crop", "12")):
            with self.subTest(key):
                self.refused(spoilt(lambda _, notes, it=(key, value): notes.update([it])), f'({key} is "{value}"')

    def test_cut_off_and_damaged(self):
        folder = SCRATCH / "cut"
        whole = shard_of(WHOLE).read_bytes()
        head = json.dumps({"0/pixel.normal": {"dtype": "F32", "shape": [-1, -4], "data_offsets": [0, 16]}}).encode()
        many = json.dumps({"x": {"dtype": "F32", "shape": [1 << 32, 1 << 32], "data_offsets": [0, 0]}}).encode()
        for content, expected in (
            (whole[:-1], "it is cut off"),
            (whole[:2000], "it is cut off"),
            (whole[:5], "not a safetensors file"),
            (b"", "not a safetensors file"),
            (len(head).to_bytes(8, "little") + head + bytes(16), "a size or a place that is none"),
            (len(many).to_bytes(8, "little") + many, "takes other than the bytes of its shape"),
            ((1 << 17).to_bytes(8, "little") + b"[" * (1 << 17), "not a safetensors file"),
            (whole.replace(b'"F16"', b'"F17"', 1), "of type F17"),
        ):
            shutil.rmtree(folder, ignore_errors=True)
            shutil.copytree(WHOLE, folder)
            shard_of(folder).write_bytes(content)
            with self.subTest(expected):
                self.refused(folder, expected)
                self.refused(folder, "cut/shard-0000000000-0000000002.safetensors: ")
        shard_of(folder).unlink()
        os.mkfifo(folder / "shard-0000000000-0000000002.safetensors")
        self.refused(folder, "not a regular file")

    def test_folders(self):
        empty = SCRATCH / "empty"
        empty.mkdir()
        self.refused(empty, f"{empty}/manifest.json: there is none")
        self.refused(shard_of(WHOLE), "manifest.json: there is none")
        larger = dataset(SCRATCH / "larger", samples=2, size=32)
        self.refused(WHOLE, f"{larger}: its crops have 32 pixels a side, not 24 as those of {WHOLE}", larger)

    def test_manifests(self):
        folder = SCRATCH / "listed"
        shutil.copytree(WHOLE, folder)
        path = folder / "manifest.json"
        whole = json.loads(path.read_text())
        for change, expected in (
            ({"settings": whole["settings"] | {"format": "5"}}, f"of version 5, not {INPUTS_VERSION}; make it anew"),
            ({"settings": whole["settings"] | {"crop": "x"}}, "not the manifest of a data set"),
            ({"shards": [whole["shards"][0] | {"file": "../whole/" + shard_of(WHOLE).name}]}, "none of this folder"),
            ({"shards": [whole["shards"][0] | {"samples": 10**12}]}, "holds other samples"),
            ({"shards": []}, "no sample with a light"),
            ({"shards": 7}, "not the manifest of a data set"),
        ):
            path.write_text(json.dumps(whole | change))
            with self.subTest(expected):
                self.refused(folder, expected)
        path.write_text("[" * 100000)
        self.refused(folder, "not the manifest of a data set")


class Accepted(unittest.TestCase):
    def test_a_sample_without_lights_is_left_out(self):
        """And everything else may be F32."""

        def change(arrays: Arrays, _: dict[str, str]) -> None:
            for name in list(arrays):
                seed, _, rest = name.partition("/")
                arrays[name] = arrays[name].astype(np.float32)
                if seed == "1" and rest.partition(".")[0] in ("light", "vpl", "texel", "view"):
                    arrays[name] = arrays[name][:, :0] if rest.startswith("view") else arrays[name][:0]

        output = SCRATCH / "dark.safetensors"
        status, said, errors = train(spoilt(change), "-o", output, "--steps", "1", "--threads", "1")
        self.assertEqual((status, errors), (0, ""))
        self.assertIn("2 of 4 crops are held out", said)
