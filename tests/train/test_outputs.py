"""What a training leaves behind: nothing is lost by another run, a signal, a kill, a full disk; nothing foreign runs."""

import io
import os
import pickle
import resource
import shutil
import signal
import stat
import unittest
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from unittest import mock
from zipfile import ZipFile

import torch
from made import ROOT, dataset, train

from lightformer_train import files, machine, network_file, training, weights
from lightformer_train.data import Dataset
from lightformer_train.outputs import Outputs, Stopped, read_checkpoint
from lightformer_train.training import Interrupted, Settings, Trainer

SCRATCH = Path(os.environ["NG_TEST_DIR"])
CPU = torch.device("cpu")


def setUpModule() -> None:
    shutil.rmtree(SCRATCH, ignore_errors=True)  # of a run before
    SCRATCH.mkdir(parents=True)
    dataset(SCRATCH / "data", samples=4, crops=1)


def trainer(name: str, steps: int = 3, **changes: object) -> Trainer:
    settings = Settings("lean", steps=steps, batch=1, held_out=1, threads=1, **changes)
    return Trainer(settings, Dataset([SCRATCH / "data"]), SCRATCH / f"{name}.safetensors", ROOT)


def command(name: str, *options: str) -> tuple[int, str, str]:
    """The same training by its command."""
    arguments = "--steps 3 --batch 1 --held-out 1 --threads 1".split()
    return train(SCRATCH / "data", "-o", SCRATCH / f"{name}.safetensors", *arguments, *options)


def interrupt(name: str, number: int = signal.SIGINT, step: int = 2) -> Outputs:
    """A training that a signal ends."""
    interrupted = trainer(name)
    interrupted._note = lambda: interrupted.step == step and os.kill(os.getpid(), number)
    with redirect_stdout(io.StringIO()):
        try:
            interrupted.run()
        except Interrupted:
            pass
    return interrupted.outputs


def step_of(outputs: Outputs) -> int:
    return read_checkpoint(outputs.checkpoint, CPU)["step"]


class Overwriting(unittest.TestCase):
    def refused(self, name: str, expected: str, *options: str) -> None:
        """With one line, and all files as they are."""
        before = {path: path.read_bytes() for path in SCRATCH.glob(f"{name}.*")}
        status, _, errors = command(name, *options)
        self.assertEqual((status, errors.count("\n")), (1, 1), errors)
        self.assertIn(f"train: {SCRATCH}/{name}.{expected}", errors)
        self.assertEqual(before, {path: path.read_bytes() for path in SCRATCH.glob(f"{name}.*")})

    def test_an_interrupted_training_stays(self):
        outputs = interrupt("begun")
        self.refused("begun", "checkpoint: an interrupted training left it; --resume goes on from there, --force")
        status, said, errors = command("begun", "--resume")
        self.assertEqual((status, errors), (0, ""))
        self.assertIn("goes on at step 2 of 3\n", said)
        self.assertFalse(outputs.checkpoint.exists() or outputs.lock.exists())
        self.refused("begun", "safetensors: is there already; --force overwrites it")
        self.refused("begun", "checkpoint: there is none", "--resume")

    def test_data_are_no_output(self):
        linked = SCRATCH / "linked.safetensors"
        linked.symlink_to(next((SCRATCH / "data").glob("shard-*")))
        (SCRATCH / "hard.html").hardlink_to(SCRATCH / "data" / "manifest.json")
        before = linked.read_bytes()
        for name, clash in (("linked", "linked.safetensors"), ("hard", "hard.html")):
            status, _, errors = command(name, "--force")
            self.assertEqual((status, errors.count("\n")), (2, 1), errors)
            self.assertIn(f"{clash}: is a file of the data", errors)
        self.assertEqual(before, linked.read_bytes())

    def test_force_begins_anew(self):
        outputs = interrupt("anew")
        status, said, errors = command("anew", "--force")
        self.assertEqual((status, errors), (0, ""))
        self.assertNotIn("goes on", said)
        before = outputs.network.stat().st_mtime_ns
        self.assertEqual(command("anew", "--force")[0], 0)
        self.assertNotEqual(before, outputs.network.stat().st_mtime_ns)

    def test_a_forced_training_that_is_killed_leaves_no_checkpoint_of_another(self):
        outputs = interrupt("forced")
        killed = trainer("forced")
        killed._run_steps = lambda: self.assertFalse(outputs.checkpoint.exists())
        with redirect_stdout(io.StringIO()):
            killed.run()

    def test_a_report_of_that_name_stays(self):
        (SCRATCH / "page.html").write_text("mine")
        self.refused("page", "html: is there already; --force overwrites it")

    def test_a_network_that_another_wrote_stays(self):
        """Resuming ends in a file that was not there when the training began, or is its own."""
        outputs = interrupt("other")
        torch.manual_seed(1)
        network_file.save(outputs.network, network_file.create("lean"), {"training": "of another"})
        self.refused("other", "safetensors: is there already", "--resume")
        self.assertEqual(command("other", "--resume", "--force")[0], 0)

    def test_a_network_that_is_written_goes_on(self):
        """Killed between the network and the end."""
        outputs = trainer("written").outputs
        with mock.patch.object(Path, "unlink"):  # what ends with the checkpoint's
            self.assertEqual(command("written")[0], 0)
        before = outputs.network.read_bytes()
        outputs.report.unlink()
        self.assertEqual(command("written", "--resume")[0], 0)
        self.assertEqual(outputs.network.read_bytes(), before)
        self.assertTrue(outputs.report.exists())

    def test_one_training_at_a_time(self):
        with files.locked(SCRATCH / "busy.checkpoint.lock", "this test"):
            status, _, errors = command("busy")
        self.assertEqual((status, errors), (1, f"train: {SCRATCH}/busy.safetensors: another training is at work there\n"))
        self.assertFalse((SCRATCH / "busy.checkpoint.lock").exists())


class Interrupts(unittest.TestCase):
    def test_each_leaves_a_checkpoint(self):
        for number in training.INTERRUPTS:
            with self.subTest(number):
                self.assertEqual(step_of(interrupt(f"signal{number}", number)), 2)

    def test_the_command_says_so(self):
        with mock.patch.object(Trainer, "_note", lambda self: os.kill(os.getpid(), signal.SIGHUP)):
            status, _, errors = command("told")
        self.assertEqual((status, errors), (130, "train: interrupted at step 1; --resume goes on\n"))

    def test_while_judging(self):
        """The checkpoint is there already."""
        with mock.patch.object(Trainer, "_finish", lambda self: os.kill(os.getpid(), signal.SIGTERM)):
            status, _, errors = command("judging")
        self.assertEqual((status, errors), (130, "train: interrupted; --resume goes on\n"))
        self.assertEqual(step_of(Outputs(SCRATCH / "judging.safetensors")), 3)

    def test_what_is_ignored_stays_ignored(self):
        """As nohup has it."""
        before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
        try:
            outputs = interrupt("ignored", signal.SIGHUP)
        finally:
            signal.signal(signal.SIGHUP, before)
        self.assertTrue(outputs.network.exists())


class FullDisk(unittest.TestCase):
    def test_the_checkpoint_before_stays_and_the_training_goes_on(self):
        full = trainer("full")
        limits = resource.getrlimit(resource.RLIMIT_FSIZE)
        found = []

        def note() -> None:
            """A checkpoint after each step; the second meets a full disk."""
            resource.setrlimit(resource.RLIMIT_FSIZE, (1000 if full.step == 2 else limits[0], limits[1]))
            full._save_checkpoint()
            found.append(step_of(full.outputs))

        full._note = note
        errors = io.StringIO()
        try:
            with redirect_stdout(io.StringIO()), redirect_stderr(errors):
                full.run()
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        self.assertEqual(found, [1, 1, 3])
        self.assertRegex(errors.getvalue(), r"^train: .*full.checkpoint: cannot be written .*; that of step 1 stays\n$")
        self.assertTrue(full.output.exists())

    def test_an_interrupt_then_says_where_it_goes_on(self):
        full = trainer("stopped")
        full._save_checkpoint()
        full.step, full.interrupted = 2, True
        with mock.patch.object(files, "_fill", side_effect=OSError(28, "No space left on device")):
            with redirect_stderr(io.StringIO()), self.assertRaisesRegex(Interrupted, "2; --resume goes on at step 0"):
                full._stop()


class Precision(unittest.TestCase):
    def test_bf16_where_the_cpu_multiplies_it(self):
        for flags, expected in (("avx2", "fp32"), ("avx512f avx512_bf16", "bf16"), ("amx_bf16", "bf16"), ("", "fp32")):
            with self.subTest(flags), mock.patch.object(machine, "_cpu_flags", lambda flags=flags: flags.split()):
                self.assertEqual(machine.name_of(machine.precision("auto", CPU)), expected)
                self.assertIn("slowly" if expected == "fp32" else "multiplies it", machine.said(torch.bfloat16, CPU))
                self.assertEqual(machine.precision("bf16", CPU), torch.bfloat16)

    def test_a_machine_of_another_precision_goes_on(self):
        """Whether the machine chooses or a person does."""
        for name, of_first, of_second in (("machines", "auto", "auto"), ("persons", "fp32", "bf16")):
            first = trainer(name, precision=of_first)
            first.step = 1
            with mock.patch.object(machine, "_cpu_flags", list):
                first._save_checkpoint()
            said = io.StringIO()
            with mock.patch.object(machine, "_cpu_flags", lambda: ["avx512_bf16"]), redirect_stdout(said):
                second = trainer(name, precision=of_second)
                second.resume()
                second.run()
            self.assertIn("its steps so far were in fp32, those to come are in bf16\n", said.getvalue())
            self.assertIn("products in bf16: ", said.getvalue())
            _, notes = weights.read(second.output)
            self.assertEqual(notes["precision"], "fp32, bf16 from step 1")


class Foreign(unittest.TestCase):
    """Checkpoints of others: a pickle may name any function."""

    class Evil:
        def __reduce__(self):
            return os.mkdir, (str(SCRATCH / "done"),)

    def refused(self, name: str) -> None:
        with self.assertRaisesRegex(Stopped, f"{name}.checkpoint: not a checkpoint, or damaged"):
            trainer(name).resume()
        self.assertFalse((SCRATCH / "done").exists())

    def test_what_a_pickle_names_is_not_called(self):
        for name, protocol in (("zip", True), ("legacy", False)):
            whole = trainer(name)
            whole._save_checkpoint()
            state = read_checkpoint(whole.outputs.checkpoint, CPU)
            torch.save(state | {"more": self.Evil()}, whole.outputs.checkpoint, _use_new_zipfile_serialization=protocol)
            self.refused(name)
        (SCRATCH / "plain.checkpoint").write_bytes(pickle.dumps(self.Evil()))
        self.refused("plain")
        with open(SCRATCH / "behind.checkpoint", "wb") as file:  # a zip may begin anywhere in its file
            file.write(pickle.dumps(self.Evil()))
            with ZipFile(file, "w") as archive:
                archive.writestr("archive/data.pkl", pickle.dumps({}))
        self.refused("behind")

    def test_a_program_is_not_loaded(self):
        torch.jit.save(torch.jit.script(torch.nn.Identity()), SCRATCH / "script.checkpoint")
        self.refused("script")

    def test_what_is_not_of_a_training(self):
        whole = trainer("odd")
        whole._save_checkpoint()
        state = read_checkpoint(whole.outputs.checkpoint, CPU)
        for wrong in ({"step": "many"}, {"step": 4}, {"total": -1}, {"history": '[{"a": 1}, {}]'}, {"precisions": 3}):
            torch.save(state | wrong, whole.outputs.checkpoint)
            with self.subTest(wrong):
                self.refused("odd")


class Files(unittest.TestCase):
    def test_a_kill_leaves_the_file_before(self):
        """Whenever it comes; what it had begun is found and removed."""
        path = SCRATCH / "killed.txt"
        files.write_atomically(path, b"before")
        child = os.fork()
        if not child:
            os.replace = lambda *_: os.kill(os.getpid(), signal.SIGKILL)
            files.write_atomically(path, b"after")
        self.assertEqual(os.waitpid(child, 0)[1], signal.SIGKILL)
        self.assertEqual((path.read_bytes(), len(list(SCRATCH.glob("killed.txt.*")))), (b"before", 1))
        files.remove_unfinished(path)
        self.assertEqual(list(SCRATCH.glob("killed.txt*")), [path])

    def test_mode_and_link_stay(self):
        path, link = SCRATCH / "kept.txt", SCRATCH / "link.txt"
        link.symlink_to(path.name)
        files.write_atomically(link, b"one")  # to a file that is not there yet
        path.chmod(0o640)
        files.write_atomically(link, b"two")
        self.assertTrue(link.is_symlink())
        self.assertEqual((path.read_bytes(), stat.S_IMODE(path.stat().st_mode)), (b"two", 0o640))
        path.chmod(0o444)
        for write in (lambda: files.write_atomically(path, b"three"), lambda: files.check_target(path, 1)):
            with self.assertRaisesRegex(files.FileError, "kept.txt: cannot be written .it is write-protected"):
                write()
        self.assertEqual(path.read_bytes(), b"two")
        with self.assertRaisesRegex(files.FileError, "not a regular file"):
            files.write_atomically(Path("/dev/null"), b"")

    def test_a_lock_is_free_once_its_holder_has_ended(self):
        path = SCRATCH / "a.lock"
        path.write_bytes(b"")  # of one that was killed
        with files.locked(path, "one"):
            with self.assertRaisesRegex(files.FileError, "another is at work there"), files.locked(path, "another"):
                pass
        with files.locked(path, "again"):
            pass
        self.assertFalse(path.exists())
