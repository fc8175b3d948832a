"""Ingests a recording set in parts, on the workers of a Dask cluster.

    python ingest.py my-pushes -o steps.parquet --parts 100 --scheduler tcp://head-node:8786

writes the bytes of one ``pushlab ingest "$PWD/my-pushes" --step 200ms -o steps.parquet``: a table names the
arguments that made it. Workers see the same folders as this program. What was done stays:
after an interruption, or a worker that died, only what is missing is made.
"""

import argparse
import shutil
from pathlib import Path

from dask.distributed import Client, as_completed

import pushlab

# One task a worker, one thread a task: more would wait for each other.
LOCAL = {"threads_per_worker": 1, "env": {"RAYON_NUM_THREADS": "1"}}


def ingest_part(recordings, part, table, step):
    """Writes a part's table with its report beside it, each as a whole or not at all."""
    if not (table.exists() and table.with_suffix(".json").exists()):
        options = {"part": part, "output": table, "step": step, "force": True}
        pushlab.command("ingest", recordings, **options, progress=False)


def ingest(client, recordings, output, n_parts, step):
    """Ingests all parts and merges them."""
    folder = Path(f"{output}.{n_parts}-parts-of-{step}")
    folder.mkdir(exist_ok=True)
    numbers = range(1, n_parts + 1)
    tables = [folder / f"{number:05}.parquet" for number in numbers]
    parts = [f"{number}/{n_parts}" for number in numbers]
    n = len(parts)
    # Where a worker is lost and yet at work, another that takes its part is refused: it waits and tries again.
    tasks = client.map(ingest_part, [recordings] * n, parts, tables, [step] * n, pure=False, retries=3)
    for done, _ in enumerate(as_completed(tasks, with_results=True), start=1):
        print(f"\r{done} of {n} parts", end="", flush=True)
    print()
    print(pushlab.command("merge", *tables, output=output))
    shutil.rmtree(folder)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recordings", type=Path, help="a folder with a dataset.toml")
    parser.add_argument("-o", "--output", type=Path, required=True, help="the step table to write")
    parser.add_argument("--parts", type=int, default=16, help="how many parts (default: 16)")
    parser.add_argument("--step", default="200ms", help="length of a step (default: 200ms)")
    parser.add_argument("--scheduler", help="address of a cluster; else the processors of this machine")
    given = parser.parse_args()
    if given.output.exists():
        parser.error(f"{given.output} exists")
    with Client(given.scheduler) if given.scheduler else Client(**LOCAL) as client:
        ingest(client, given.recordings.resolve(), given.output.resolve(), given.parts, given.step)


if __name__ == "__main__":
    main()
