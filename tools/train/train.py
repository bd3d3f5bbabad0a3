#!/usr/bin/python3
"""Trains a network on data sets of `lightformer dataset`.

    tools/train/train.py out/chess -o out/chess.safetensors --minutes 40
    tools/train/train.py out/chess -o out/flat.safetensors --without attention --steps 5000
    tools/train/train.py out/chess -o out/chess.safetensors --processes 2 --threads 1 --batch 2
    torchrun --nproc_per_node 4 tools/train/train.py ...

Writes the network, a report beside it (.html) and, while it works, a checkpoint (.checkpoint), from which --resume
goes on: every two minutes, and after Ctrl-C, SIGTERM or SIGHUP, which end it after the step at work. Nothing that is
there is overwritten without --force.

Exit codes: 0 done, 1 failed, 2 a wrong command line, 130 interrupted.
"""

import argparse
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

# Threads that spin while they wait for each other starve on a machine that does other work as well.
os.environ.setdefault("OMP_WAIT_POLICY", "passive")
sys.path.insert(0, str(Path(__file__).resolve().parent))
try:
    from lightformer_train import families, files, machine, program
    from lightformer_train.arguments import SEEDS, Parser, factor, positive, whole
    from lightformer_train.data import Dataset, required_inputs
    from lightformer_train.outputs import Outputs, Stopped
    from lightformer_train.training import Interrupted, Settings, Trainer
except ModuleNotFoundError as missing:
    sys.exit(f"train: {missing}; tools/setup --train installs it, for /usr/bin/python3")

ROOT = Path(__file__).resolve().parents[2]


def parse() -> argparse.Namespace:
    """The command line."""
    parser = Parser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("data", nargs="+", type=Path, metavar="DATA", help="folder of a data set")
    add("-o", "--output", type=Path, required=True, metavar="OUT.safetensors", help="the network")
    add("--preset", default="lean", choices=families.PRESETS, help="default %(default)s; program.py tells")
    add("--without", nargs="+", default=[], metavar="PART", help="parts to leave out; program.py PRESET lists them")
    length = parser.add_mutually_exclusive_group()
    length.add_argument("--minutes", type=positive, default=Settings.minutes, help="default %(default)s")
    length.add_argument("--steps", type=whole(1), default=Settings.steps, help="instead of minutes")
    add("--resume", action="store_true", help="go on from the checkpoint, to its last step")
    add("--force", action="store_true", help="overwrite what is there: network, report and, unless resumed, checkpoint")
    add("--batch", type=whole(1, 1 << 16), default=Settings.batch, help="crops of a process's step (default %(default)s)")
    add("--processes", type=whole(1, 1024), default=Settings.processes, help="on this machine (default %(default)s)")
    add("--rate", type=positive, default=Settings.rate, help="of learning, at first (default %(default)s)")
    add("--seed", type=whole(0, SEEDS - 1), default=Settings.seed, help="of what is drawn (default %(default)s)")
    add("--held-out", type=whole(1), default=Settings.held_out, help="crops to judge by (default %(default)s)")
    add(
        "--precision",
        default=Settings.precision,
        choices=(machine.AUTO, *machine.PRECISIONS),
        help="of products; auto: bf16 where CPU or GPU multiply it, fp32 elsewhere (default %(default)s)",
    )
    add(
        "--perceptual",
        default=Settings.perceptual,
        choices=("differences", "vgg"),
        help="term of the loss: of neighbours, or of VGG-16's features (default %(default)s)",
    )
    add("--vpls", type=whole(1, 1 << 20), default=Settings.vpls, help="of a light in a step (default %(default)s)")
    add("--texels", type=whole(1, 1 << 20), default=Settings.texels, help="of a light in a step (default %(default)s)")
    add(
        "--radii",
        type=factor,
        default=Settings.radii,
        metavar="S",
        help="scenes as if their radius were 1 / S to S times as large, for networks of scenes of any size (default 1)",
    )
    add("--threads", type=whole(0, 1024), default=Settings.threads, help="of a process (default: all cores)")
    return parser.parse_args()


@contextmanager
def _others(count: int) -> Iterator[None]:
    """Starts the other processes of a training on this machine, unless torchrun or a person did."""
    if count == 1 or "RANK" in os.environ:
        yield
        return
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        group = {"MASTER_ADDR": "127.0.0.1", "MASTER_PORT": str(free.getsockname()[1])}
    group |= {"WORLD_SIZE": str(count), "LOCAL_WORLD_SIZE": str(count)}
    os.environ.update(group | {"RANK": "0", "LOCAL_RANK": "0"})
    others = [
        subprocess.Popen([sys.executable, *sys.argv], env=os.environ | {"RANK": str(i), "LOCAL_RANK": str(i)})
        for i in range(1, count)
    ]
    try:
        yield
        for other in others:
            other.wait()
    finally:  # those that still run wait for this one in vain
        for other in others:
            other.kill()
            other.wait()


def _train(settings: Settings, folders: list[Path], outputs: Outputs, resume: bool, force: bool) -> None:
    """One process of it."""
    if not resume and not force:
        outputs.refuse_to_overwrite()
    outputs.network.parent.mkdir(parents=True, exist_ok=True)
    first = os.environ.get("RANK", "0") == "0"
    with files.locked(outputs.lock, f"{outputs.network}: another training") if first else nullcontext():
        checked = program.check(families.build(settings.preset, settings.without))
        with _others(settings.processes):
            dataset = Dataset(folders, required_inputs(checked))
            if first:
                dataset.check_numbers()
            trainer = Trainer(settings, dataset, outputs.network, ROOT)
            if resume:
                trainer.resume(force)
            trainer.run()


def _status(error: Exception) -> int:
    """Says what has happened; the exit code."""
    if os.environ.get("RANK", "0") == "0":
        named = isinstance(error, OSError) and error.filename
        print(f"train: {error.filename}: {error.strerror}" if named else f"train: {error}", file=sys.stderr)
    return 130 if isinstance(error, Interrupted) else 1


def main() -> int:
    """The command."""
    arguments = vars(parse())
    folders, output, resume, force = (arguments.pop(name) for name in ("data", "output", "resume", "force"))
    settings = Settings(**arguments | {"without": frozenset(arguments["without"])})
    outputs = Outputs(output)
    try:
        families.build(settings.preset, settings.without)
    except ValueError as error:
        print(f"train: {error}", file=sys.stderr)
        return 2
    clash = outputs.clash(folders)
    if clash:
        print(f"train: {clash}: is a file of the data, which it would overwrite; choose another -o", file=sys.stderr)
        return 2
    Trainer.handle(signal.default_int_handler)
    try:
        _train(settings, folders, outputs, resume, force)
    except (Stopped, files.FileError, OSError) as error:
        return _status(error)
    except (MemoryError, RuntimeError) as error:
        if "memory" not in str(error).lower() and not isinstance(error, MemoryError):
            raise
        return _status(Stopped("not enough memory; lower --batch, --texels or --processes"))
    except KeyboardInterrupt:  # before the first step or after the last, where a checkpoint is
        return _status(Interrupted("interrupted" + ("; --resume goes on" if outputs.checkpoint.exists() else "")))
    return 0


if __name__ == "__main__":
    sys.exit(main())
