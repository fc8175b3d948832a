"""Fits effects of a model to a recording set in parts, on the workers of a Dask cluster.

    python fit.py my-pushes --free pusher-friction -o fitted.toml --parts 100 --scheduler tcp://head-node:8786

A round: each part is summed up where the fit stands, the sums are merged, and a step is taken, until none is left.
Workers see the same folders as this program. What was done stays: after an interruption, or a worker that died,
only what is missing is made.
"""

import argparse
import json
import shutil
from pathlib import Path

from dask.distributed import Client, as_completed

import pushlab

# One task a worker, one thread a task: more would wait for each other.
LOCAL = {"threads_per_worker": 1, "env": {"RAYON_NUM_THREADS": "1"}}
MOST_ROUNDS = 100


def begin(recordings, sample, model, free, output):
    """What a sample of the set tells all parts."""
    if not output.exists():
        options = {"part": sample, "model": model, "free": free, "output": output, "force": True}
        pushlab.command("statistics", recordings, **options, progress=False)


def sum_up(recordings, part, last, output):
    """What a part says where the fit stands after a round."""
    if not output.exists():
        options = {"part": part, "round": last, "output": output, "force": True}
        pushlab.command("statistics", recordings, **options, progress=False)


def fit(client, recordings, model, free, output, n_parts):
    """Fits to all parts, in rounds."""
    folder = Path(f"{output}.{n_parts}-parts")
    folder.mkdir(exist_ok=True)
    parts = [f"{number}/{n_parts}" for number in range(1, n_parts + 1)]
    last, fitted = folder / "round-000.json", folder / "fitted.toml"
    # Where a worker is lost and yet at work, another that takes its part is refused: it waits and tries again.
    again = {"pure": False, "retries": 3}
    client.submit(begin, recordings, parts[0], model, free, last, **again).result()
    for number in range(1, MOST_ROUNDS + 1):
        merged = folder / f"round-{number:03}.json"
        if not merged.exists():
            files = [folder / f"round-{number:03}-{part:05}.json" for part in range(1, n_parts + 1)]
            n = [recordings] * n_parts, [last] * n_parts
            tasks = client.map(sum_up, n[0], parts, n[1], files, **again)
            for _ in as_completed(tasks, with_results=True):
                pass
            pushlab.command("merge", *files, output=merged, fitted=fitted, force=True, progress=False)
            for file in files:
                file.unlink()
        found = json.loads(merged.read_text(encoding="utf-8"))["fit"]
        print(f"round {number}: {found['decrement']:.2g} standard errors² from the minimum", flush=True)
        if found["is_converged"]:
            break
        last = merged
    else:
        raise SystemExit(f"not converged after {MOST_ROUNDS} rounds")
    for effect in found["effects"]:
        for estimate in effect["parameters"]:
            name, value, se = estimate["name"], estimate["value"], estimate["se"]
            print(f"{effect['id']} {name}: {value:.4g} ± {se:.2g} {estimate['unit']}")
    fitted.rename(output)
    shutil.rmtree(folder)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recordings", type=Path, help="a folder with a dataset.toml")
    parser.add_argument("--model", type=Path, default=Path("model.toml"), help="the model to start from")
    parser.add_argument("--free", required=True, help="what to fit, with commas between")
    parser.add_argument("-o", "--output", type=Path, required=True, help="the fitted model to write")
    parser.add_argument("--parts", type=int, default=16, help="how many parts (default: 16)")
    parser.add_argument("--scheduler", help="address of a cluster; else the processors of this machine")
    given = parser.parse_args()
    if given.output.exists():
        parser.error(f"{given.output} exists")
    with Client(given.scheduler) if given.scheduler else Client(**LOCAL) as client:
        paths = [path.resolve() for path in (given.recordings, given.model, given.output)]
        fit(client, paths[0], paths[1], given.free, paths[2], given.parts)


if __name__ == "__main__":
    main()
