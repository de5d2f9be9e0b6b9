"""`python -m elastogeo.fleet`: a command over many campaigns."""

from __future__ import annotations

import argparse
import contextlib
import os
import signal
import sys
from collections.abc import Iterator, Mapping, Sequence
from types import FrameType

from . import engine
from .jobs import COMMANDS, BadInput, Job, jobs
from .progress import Progress
from .work import Row, version

EPILOG = """\
Campaigns are folders (or folders above them), files, patterns, bundled names, or a text file with a path in each line.
Of `track` the campaigns of a folder are those of one robot, in the order of their names; of `blind` they are what
`elastogeo blind make` wrote. What is in the dataset already of the same files, settings and version is not run again.

  python -m elastogeo.fleet identify robots/ --into results
  python -m elastogeo.fleet diagnose 'robots/*/2026-*' --into results --scheduler tcp://10.0.0.5:8786
  python -m elastogeo.fleet identify list.txt --into results -- --loss huber --seed 3

Exit status: 0 all done, 1 campaigns without a usable result, 2 bad input, 130 interrupted.
"""


def main(given: Sequence[str] | None = None) -> int:
    """Runs the command: the exit status."""
    given = list(sys.argv[1:] if given is None else given)
    at = given.index("--") if "--" in given else len(given)
    own, options = given[:at], given[at + 1 :]
    arguments = parser().parse_args(own)
    try:
        from .dataset import Dataset, part  # what is optional is asked for when it is needed

        every = jobs(arguments.command, arguments.campaigns, options)
        every.sort(key=lambda job: (part(job.path), job.key))
        dataset = Dataset(arguments.into)
        with contextlib.closing(dataset):
            todo = [job for job in every if dataset.status(job, version()) is None]
            progress = Progress(len(todo))
            left: dict[int, int] = {}
            for job in todo:
                left[part(job.path)] = left.get(part(job.path), 0) + 1
            try:
                with running(arguments, todo) as results:
                    for job, row in results:
                        dataset.add(row)
                        left[part(job.path)] -= 1
                        dataset.write([] if left[part(job.path)] else [part(job.path)])
                        progress.step(row["status"] != "done")
            finally:
                progress.end()
                dataset.write_all()
            return conclude(every, [dataset.status(job, version()) for job in every], progress, dataset.errors(every))
    except ImportError as error:
        return refuse(f"{error}; `pip install '.[fleet]'` in a clone of elastogeo installs what fleets need")
    except BadInput as error:
        return refuse(str(error))
    except OSError as error:
        return refuse(f"{error}; what was done is kept, and the same command goes on")
    except KeyboardInterrupt:
        print("interrupted: what was done is kept, and the same command goes on", file=sys.stderr)
        return 130


def parser() -> argparse.ArgumentParser:
    """Of the arguments before `--`."""
    out = argparse.ArgumentParser(
        prog="python -m elastogeo.fleet",
        description="Runs a command on many campaigns: a Parquet dataset, a row for each.",
        usage="%(prog)s [options] {" + ",".join(COMMANDS) + "} CAMPAIGNS.. --into FOLDER [-- options of the command]",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    out.add_argument("command", choices=COMMANDS)
    out.add_argument("campaigns", nargs="+", metavar="CAMPAIGNS")
    out.add_argument("--into", required=True, metavar="FOLDER", help="folder of the dataset")
    how = out.add_mutually_exclusive_group()
    how.add_argument(
        "--workers", type=count, metavar="N", help="processes on this machine; by default one for each processor"
    )
    how.add_argument(
        "--scheduler", metavar="ADDRESS", help="a Dask scheduler: its address or its scheduler file (.json)"
    )
    how.add_argument("--sequential", action="store_true", help="one after another in this process, without Dask")
    return out


def count(text: str) -> int:
    """A number of processes."""
    if not text.isdecimal() or not 1 <= int(text) <= 1024:
        raise argparse.ArgumentTypeError(f"`{text}` is no number from 1 to 1024")
    return int(text)


@contextlib.contextmanager
def running(arguments: argparse.Namespace, todo: Sequence[Job]) -> Iterator[Iterator[tuple[Job, Row]]]:
    """The results as they come, until Ctrl-C or the end that a batch system sends."""
    heard = False

    def interrupt(_number: int, _frame: FrameType | None) -> None:
        nonlocal heard
        heard = True
        raise KeyboardInterrupt

    def heeding(results: Iterator[tuple[Job, Row]]) -> Iterator[tuple[Job, Row]]:
        for each in results:
            yield each
            # Python drops an exception that is raised within a destructor or a callback of a library.
            if heard:
                raise KeyboardInterrupt

    before = {number: signal.signal(number, interrupt) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        if arguments.sequential or not todo:
            yield heeding(engine.sequential(todo))
            return
        workers = min(arguments.workers or os.cpu_count() or 1, len(todo))
        with engine.connected(arguments.scheduler, workers) as client:
            engine.check_workers(client)
            yield heeding(engine.distributed(todo, client))
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def conclude(every: Sequence[Job], status: Sequence[str | None], progress: Progress, why: Mapping[Job, str]) -> int:
    """What was found, in a few lines: the exit status."""
    failed = [(job, each or "lost") for job, each in zip(every, status) if each != "done"]
    there = len(every) - progress.done
    ran = f"{progress.done} run in {progress.seconds:.1f} s"
    print(f"{len(every)} campaigns: {there} there before, {ran}, {len(failed)} failed")
    for job, each in failed[:10]:
        print(f"{each}: {job.path}" + (f": {why[job]}" if job in why else ""), file=sys.stderr)
    if len(failed) > 10:
        print(f".. and {len(failed) - 10} more; the columns `status` and `error` of the dataset tell", file=sys.stderr)
    return 1 if failed else 0


def refuse(message: str) -> int:
    """Says why nothing was begun, or why it ended."""
    print(f"error: {message}", file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main())
