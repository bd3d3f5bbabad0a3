"""The loop: steps of Adam with cosine decay, a running mean of the weights, checkpoints, judgements, the report.

Everything follows from settings, data and the number of steps: batches are drawn from seed and step, and the learning
rate of the first steps, which are timed to turn minutes into steps, does not depend on how many there will be. So
`--steps` with the recorded number repeats a run of `--minutes`, and a resumed run equals one that was not interrupted.
"""

import json
import math
import shlex
import signal
import statistics
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NoReturn

import numpy as np
import torch

from . import data, files, losses, machine, network_file, program, quality, vgg, weights
from .data import Batch, Crop, Dataset
from .network import Network
from .outputs import Outputs, Stopped, read_checkpoint, write_checkpoint
from .report import History, page

WARM_UP = 60  # steps over which the learning rate rises; those after TIMED_FROM are timed
TIMED_FROM = 20
STEPPING = 0.95  # of the minutes; the rest goes to judging and checkpoints
MEAN_DECAY = 0.999  # of the running mean of the weights, which is what is judged and written
GRADIENT_LIMIT = 1.0  # of the norm: one bright path must not throw the weights about

NOTED = 200  # points of a curve of losses
JUDGED = 10  # times, with so many crops until the last:
JUDGED_CROPS = 32
SHOWN_CROPS = 6
WRITTEN = 5 * 4  # bytes a parameter: weights, mean and Adam's two in a checkpoint, and the network
CHECKPOINT_SECONDS = 120.0
PROGRESS_SECONDS = 10.0

OUTPUT = "OUT.safetensors"  # of a recorded command

# What a person or a system ends a training by; it is done with its step first, and leaves a checkpoint.
INTERRUPTS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

# Settings that decide the result, beside preset, parts and steps.
REPEATED = (
    "batch",
    "processes",
    "rate",
    "seed",
    "held_out",
    "precision",
    "perceptual",
    "vpls",
    "texels",
    "threads",
    "radii",
)


class Interrupted(Stopped):
    """By one of INTERRUPTS, with a checkpoint."""


@dataclass(frozen=True)
class Settings:
    """What a training is, beside its data."""

    preset: str
    without: frozenset[str] = frozenset()
    steps: int = 0  # 0: as many as fit into `minutes`
    minutes: float = 40.0
    batch: int = 4  # crops, of each process
    processes: int = 1
    rate: float = 2e-3
    seed: int = 0
    held_out: int = 64  # crops
    precision: str = "auto"
    perceptual: str = "differences"
    vpls: int = 128
    texels: int = 512
    threads: int = 0  # 0: all
    radii: float = 1.0  # of scenes, drawn from 1 / radii to radii times their own

    def command(self, folders: list[Path], steps: int) -> str:
        """What repeats it, where the data are; it does not depend on where that is, or on the output's name."""
        words = ["tools/train/train.py", *(folder.resolve().name for folder in folders), "-o", OUTPUT]
        words += ["--preset", self.preset]
        words += ["--without", *sorted(self.without)] if self.without else []
        words += ["--steps", str(steps)]
        for name in REPEATED:
            value = getattr(self, name)
            if value != getattr(Settings, name):
                words += [f"--{name.replace('_', '-')}", str(value)]
        return shlex.join(words)


class Every:
    """True once in so many seconds."""

    def __init__(self, seconds: float) -> None:
        self.seconds, self.last = seconds, time.monotonic()

    def __call__(self) -> bool:
        due = time.monotonic() - self.last >= self.seconds
        if due:
            self.last = time.monotonic()
        return due


class Trainer:
    """One process of a training, which writes the network `output` and what comes beside it."""

    def __init__(self, settings: Settings, dataset: Dataset, output: Path, root: Path) -> None:
        self.processes = machine.Processes()
        self.device = self.processes.device
        self.threads = machine.set_threads(settings.threads, self.processes)
        machine.keep_memory()
        self.dataset, self.output, self.outputs = dataset, output, Outputs(output)
        self.settings = settings = replace(settings, held_out=self._held_out(settings.held_out))
        self.learn, self.test = dataset.split(settings.held_out)
        if not self.learn:
            raise Stopped(f"{dataset.folders[0]}: two samples with a light are needed, to learn from and to judge by")
        self.precision = machine.precision(settings.precision, self.device)
        self.precisions = [(0, machine.name_of(self.precision))]  # of products: from which step, which
        torch.manual_seed(settings.seed)
        self.network, self.mean = (self._create() for _ in range(2))
        self.mean.load_state_dict(self.network.state_dict())
        if self.processes.first:
            self.outputs.check(WRITTEN * self.network.checked.parameters)  # now, not after hours
        self.optimizer = torch.optim.Adam(self.network.parameters(), lr=settings.rate)
        names = data.required_inputs(self.network.checked)
        self.options = data.Options(settings.vpls, settings.texels, radii=settings.radii, names=names)
        self.loss = losses.Loss(losses.Weights(), self._radiance_unit(), self._perceptual(root))
        self.history = History()
        self.step, self.total = 0, settings.steps
        self.seconds: list[float] = []  # of the steps of this run
        self.flops = 0.0  # of a step
        self.saved: int | None = None  # the step of the checkpoint on the disk, if it is of this training
        self.interrupted = False
        self.terms: list[dict[str, float]] = []  # since the last point of the curves
        self.recent = deque(maxlen=100)  # losses and seconds of steps, for the line of progress

    def _held_out(self, wanted: int) -> int:
        """At most half of the crops. Fewer than wanted are said and recorded, not refused: the usual number is more
        than a small data set has."""
        crops = len(self.dataset.crops)
        count = min(wanted, crops // 2)
        if count < wanted and self.processes.first:
            print(f"{count} of {crops} crops are held out, not {wanted}: at most half are", flush=True)
        return count

    def _create(self) -> Network:
        return network_file.create(self.settings.preset, self.settings.without, self.precision).to(self.device)

    def _perceptual(self, root: Path) -> Callable[[torch.Tensor, torch.Tensor], torch.Tensor]:
        if self.settings.perceptual == "differences":
            return losses.differences
        path = vgg.find(root)
        if path is None:
            raise Stopped("no weights of VGG-16; tools/setup --eval brings them, or leave --perceptual out")
        return vgg.Features(path, self.device)

    def _radiance_unit(self) -> float:
        count = min(len(self.learn), 64)
        chosen = [self.learn[i * len(self.learn) // count] for i in range(count)]
        return losses.radiance_unit(self._batches(chosen, replace(self.options, vpls=1, texels=1)))

    def _batches(self, crops: list[Crop], options: data.Options) -> Iterator[Batch]:
        """Crops as they are."""
        plain = replace(options, augment=False, mirror_dropout=0, radii=1.0)
        size = self.settings.batch
        for first in range(0, len(crops), size):
            group = crops[first : first + size]
            yield self.dataset.batch(group, plain, np.random.default_rng(first)).to(self.device)

    # ---- learning

    def run(self) -> None:
        """All steps that are left; then the network, judged, and the report. Interrupted, with a checkpoint, by a
        signal; Stopped, with one, if another process has ended."""
        if self.processes.first:
            self._begin()
        before = self.handle(self._interrupt)
        try:
            self._run_steps()
        except machine.Lost as lost:  # before the step changed anything
            self._stop(str(lost))
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)
        if self.processes.first:
            self._save_checkpoint()  # should judging or writing fail
            self._finish()
        self.processes.finish()

    def _begin(self) -> None:
        """What is left of others goes, what was chosen is said."""
        self.outputs.remove_unfinished()
        if self.saved is None:  # or --resume would find it, should this training be killed before its first
            self.outputs.checkpoint.unlink(missing_ok=True)
        print(machine.said(self.precision, self.device), flush=True)

    @staticmethod
    def handle(handler: Callable[..., None]) -> dict[signal.Signals, object]:
        """Sets what interrupts do; what they did before. SIGHUP stays ignored where it is, as nohup has it."""
        ignored = signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
        numbers = [number for number in INTERRUPTS if number != signal.SIGHUP or not ignored]
        return {number: signal.signal(number, handler) for number in numbers}

    def _interrupt(self, *_: object) -> None:
        """The step at work is finished first: a checkpoint lies between steps."""
        self.interrupted = True

    def _run_steps(self) -> None:
        save, speak = Every(CHECKPOINT_SECONDS), Every(PROGRESS_SECONDS)
        begun = time.monotonic()
        for batch in self._steps():
            loss = self._learn(batch.to(self.device))
            self.seconds.append(time.monotonic() - begun)
            self.recent.append((loss, self.seconds[-1]))
            self.step += 1
            self._decide_total()
            self._note()
            if self.processes.first and speak():
                print(self._progress(), flush=True)
            if self.interrupted:
                self._stop()
            if self.processes.first and save():
                self._save_checkpoint()
            begun = time.monotonic()

    def _stop(self, why: str = "interrupted") -> NoReturn:
        """Between steps."""
        if self.processes.first:
            self._save_checkpoint()
        kind = Interrupted if self.interrupted else Stopped
        why = "interrupted" if self.interrupted else why
        if self.processes.first and self.saved != self.step:  # a full disk, which has been said
            kept = "there is no checkpoint" if self.saved is None else f"--resume goes on at step {self.saved}"
            raise kind(f"{why} at step {self.step}; {kept}")
        raise kind(f"{why} at step {self.step}; --resume goes on")

    def _steps(self) -> Iterator[Batch]:
        def numbers() -> Iterator[int]:
            step = self.step
            while not self.total or step < self.total:
                yield step
                step += 1

        settings = self.settings
        return data.steps(
            self.dataset, self.learn, settings.batch, self.options, settings.seed, numbers(), self.processes.rank
        )

    def _learn(self, batch: Batch) -> float:
        """One step; its loss, the mean of all processes."""
        for group in self.optimizer.param_groups:
            group["lr"] = self._rate()
        total, terms = self.loss(self.network(batch.inputs, batch.lights), batch)
        self.optimizer.zero_grad(set_to_none=True)
        total.backward()
        parameters = [p for p in self.network.parameters() if p.grad is not None]
        mean_loss = total.detach().clone()
        self.processes.average([*(p.grad for p in parameters), mean_loss])
        loss = float(mean_loss)
        if not math.isfinite(loss):  # in one process, so all of them stop
            raise Stopped(
                f"the loss of step {self.step} is not a number; lower --rate, or look for damage in the data "
                "(lightformer dataset --check)"
            )
        torch.nn.utils.clip_grad_norm_(parameters, GRADIENT_LIMIT)
        self.optimizer.step()
        self._average_weights()
        self.terms.append(terms)
        self.flops = self._count_flops(batch)
        return loss

    def _rate(self) -> float:
        rise = min(1.0, (self.step + 1) / WARM_UP)
        fall = (self.step - WARM_UP) / max(self.total - WARM_UP, 1) if self.step > WARM_UP else 0.0
        return self.settings.rate * rise * (0.5 + 0.5 * math.cos(math.pi * min(fall, 1.0)))

    @torch.no_grad()
    def _average_weights(self) -> None:
        decay = min(MEAN_DECAY, (self.step + 1) / (self.step + 10))
        for mean, now in zip(self.mean.parameters(), self.network.parameters()):
            mean.lerp_(now, 1 - decay)

    def _decide_total(self) -> None:
        """Minutes become steps once the speed is known."""
        if self.total or self.step < WARM_UP:
            return
        typical = statistics.median(self.seconds[TIMED_FROM:] or self.seconds)  # a resumed run may have few
        steps = int(self.settings.minutes * 60 * STEPPING / typical)
        self.total = self.processes.agree(max(steps, WARM_UP + 2))

    def _count_flops(self, batch: Batch) -> float:
        """Of the products of a step: forward, and backward twice as many."""
        cost = program.cost(self.network.checked)
        pixels = batch.weight[0].numel()
        count = (cost.pixel * batch.lights.frames + cost.view * len(batch.lights.owner)) * pixels
        return 6 * count

    def _note(self) -> None:
        """Curves: means since the last point; and judgements in between."""
        if not self.total:
            return
        if self.step % max(1, self.total // NOTED) == 0:
            means = {name: statistics.fmean(terms[name] for terms in self.terms) for name in self.terms[0]}
            History.note(self.history.loss, self.step, means)
            self.terms = []
        if self.processes.first and self.step < self.total and self.step % max(1, self.total // JUDGED) == 0:
            found, _ = self._judge(self.test[:JUDGED_CROPS])
            print(f"step {self.step}: {found}", flush=True)

    def _progress(self) -> str:
        loss, seconds = (statistics.fmean(values) for values in zip(*self.recent))
        speed = 1 / seconds
        text = f"step {self.step}/{self.total or '?'}  loss {loss:.4f}  {speed:.2f} steps/s"
        text += f"  {self.flops * speed / 1e9:.0f} GFLOP/s"
        if self.total:
            text += f"  {(self.total - self.step) / speed / 60:.1f} min left"
        return text

    def _judge(self, crops: list[Crop]) -> tuple[quality.Quality, list[quality.Pictures]]:
        batches = self._batches(crops, replace(self.options, vpls=500, texels=8192))
        samples = min(found.samples_per_pixel for found in self.dataset.manifests)
        found, pictures = quality.judge(self.mean, batches, samples)
        self._check_numbers(found.is_finite())
        History.note(self.history.rse, self.step, found.rse)
        return found, pictures

    def _check_numbers(self, finite: bool = True) -> None:
        """Nothing is written of a training that has come to infinity."""
        if not finite or not all(network.parameter.isfinite().all() for network in (self.network, self.mean)):
            raise Stopped(f"the network of step {self.step} has weights or results that are not numbers; lower --rate")

    def _finish(self) -> None:
        found, pictures = self._judge(self.test)
        print(f"step {self.step}: {found}", flush=True)
        command = self._command()
        description = network_file.Description(
            self.settings.preset,
            self.settings.without,
            command,
            " && ".join(made.command() for made in self.dataset.manifests),
            self.dataset.hash,
            found.as_json(),
            self._said_precisions(),
        )
        network_file.save(self.output, self.mean, description.notes())
        text = page(
            self.output.stem,
            self._facts(command),
            self.history,
            found,
            pictures[:: max(1, len(pictures) // SHOWN_CROPS)],
        )
        files.write_atomically(self.outputs.report, text.encode())
        self.outputs.checkpoint.unlink(missing_ok=True)

    def _command(self) -> str:
        return self.settings.command(self.dataset.folders, self.total or self.step)

    def _said_precisions(self) -> str:
        """"bf16", or "bf16, fp32 from step 31"."""
        (_, first), *later = self.precisions
        return ", ".join([first, *(f"{name} from step {step}" for step, name in later)])

    def _facts(self, command: str) -> dict[str, str]:
        checked, cost = self.network.checked, program.cost(self.network.checked)
        speed = 1 / statistics.fmean(self.seconds) if self.seconds else 0.0
        return {
            "command": command,
            "data": f"{len(self.learn)} crops to learn from, {len(self.test)} held out, hash {self.dataset.hash}",
            "network": f"{checked.parameters} parameters, {cost.per_pixel(2):.0f} multiply-adds a pixel with 2 lights",
            "speed": f"{speed:.2f} steps/s, {self.flops * speed / 1e9:.0f} GFLOP/s in matrix products"
            if self.seconds
            else "no step was left",
            "machine": f"{self.device}, {self.threads} threads, {self.processes.count} processes",
            "products in": self._said_precisions(),
        }

    # ---- checkpoints

    def _identity(self) -> list:
        """What a training is. Machines differ in the precision of products, and one may go on for another."""
        settings = replace(self.settings, precision=Settings.precision)
        return [settings.command(self.dataset.folders, 0), self.dataset.hash, self.processes.count]

    def _save_checkpoint(self) -> None:
        """Where it cannot be written, the one before stays, which is said: what is trained on may yet be written."""
        self._check_numbers()
        state = {
            "identity": self._identity(),
            "network": self.network.state_dict(),
            "mean": self.mean.state_dict(),
            "optimizer": self.optimizer.state_dict()["state"],
            "history": json.dumps([self.history.loss, self.history.rse]),
            "precisions": self.precisions,
            "step": self.step,
            "total": self.total,
        }
        try:
            write_checkpoint(self.outputs.checkpoint, state)
            self.saved = self.step
        except weights.FileError as error:
            kept = "" if self.saved is None else f"; that of step {self.saved} stays"
            print(f"train: {error}{kept}", file=sys.stderr, flush=True)

    def resume(self, force: bool = False) -> None:
        """Goes on where the checkpoint is, to the step where it was to end. Stopped if it is of another training, or
        none; or if a network is there that this training did not write, unless it may be overwritten (`force`)."""
        path = self.outputs.checkpoint
        try:
            self._restore(read_checkpoint(path, self.device))
        except Stopped:
            raise
        except OSError as error:
            raise weights.unreadable(path, error) from None
        except MemoryError:
            raise
        except Exception as error:  # damaged bytes make the unpickler, and what it calls, raise anything
            said = str(error).splitlines()
            reason = said[0].rpartition("WeightsUnpickler error: ")[2] if said else type(error).__name__
            raise Stopped(f"{path}: not a checkpoint, or damaged ({reason})") from None
        if not force and not self.outputs.holds(self._command(), self.dataset.hash):
            self.outputs.refuse_to_replace()
        if self.processes.first:
            print(f"goes on at step {self.step} of {self.total or '?'}", flush=True)
        self._change_precision()

    def _restore(self, state: dict) -> None:
        path = self.outputs.checkpoint
        if state["identity"] != self._identity():
            raise Stopped(f"{path}: of other settings or data; --force begins anew and overwrites it")
        total, asked = int(state["total"]), self.settings.steps
        if not 0 <= int(state["step"]) <= (total or math.inf):
            raise ValueError(f"step {state['step']} of {total}")
        if total and asked not in (0, total):  # the rate's decay would bend, and no command repeat it
            raise Stopped(f"{path}: of {total} steps, not {asked}; resume with --steps {total}")
        self.network.load_state_dict(state["network"])
        self.mean.load_state_dict(state["mean"])
        groups = self.optimizer.state_dict()["param_groups"]
        self.optimizer.load_state_dict({"state": state["optimizer"], "param_groups": groups})
        self.history = History.restored(*json.loads(state["history"]))
        self.precisions = [(int(step), str(name)) for step, name in state["precisions"]]
        self.step, self.total = int(state["step"]), total or asked
        self.saved = self.step

    def _change_precision(self) -> None:
        """To that of this run, which is said: the checkpoint may come from another machine."""
        earlier, now = self.precisions[-1][1], machine.name_of(self.precision)
        if earlier == now:
            return
        self.precisions.append((self.step, now))
        if self.processes.first:
            print(f"its steps so far were in {earlier}, those to come are in {now}", flush=True)
