"""How large an effect has to be to be named: simulated sets of several sizes and seeds, diagnosed with Dask.

    python sweep.py 'table-tilt: x_m_s2={}, y_m_s2=0' 0.01 0.03 0.1 --scheduler tcp://head-node:8786

hides the effect in the recordings of a rig, and counts how often a diagnosis names it.
"""

import argparse
import tempfile
from pathlib import Path

from dask.distributed import Client, as_completed

import pushlab

# One task a worker, one thread a task: more would wait for each other.
LOCAL = {"threads_per_worker": 1, "env": {"RAYON_NUM_THREADS": "1"}}


def trial(hidden, seed, pushes, rig):
    """The effects that a diagnosis names in recordings with one hidden in them."""
    with tempfile.TemporaryDirectory() as folder:
        recordings = pushlab.generate(
            Path(folder) / "set", hidden=hidden, seed=seed, pushes=pushes, rig=rig, progress=False
        )
        model = pushlab.Model.nominal(recordings)
        return pushlab.diagnose(recordings, model, progress=False).identified


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("hidden", help="as of `pushlab generate`, with {} in the place of the size")
    parser.add_argument("sizes", type=float, nargs="+", help="in the SI unit of the parameter")
    parser.add_argument("--seeds", type=int, default=5, help="sets of each size (default: 5)")
    parser.add_argument("--pushes", type=int, default=100, help="pushes of each set (default: 100)")
    parser.add_argument("--rig", default="rough", help="as of `pushlab generate` (default: rough)")
    parser.add_argument("--scheduler", help="address of a cluster; else the processors of this machine")
    given = parser.parse_args()
    effect = given.hidden.split(":")[0]
    named = dict.fromkeys(given.sizes, 0)
    with Client(given.scheduler) if given.scheduler else Client(**LOCAL) as client:
        trials = {
            client.submit(trial, given.hidden.format(size), seed, given.pushes, given.rig): size
            for size in given.sizes
            for seed in range(given.seeds)
        }
        for task, identified in as_completed(trials, with_results=True):
            named[trials[task]] += effect in identified
    for size, count in named.items():
        print(f"{size:10g}: named in {count} of {given.seeds}")


if __name__ == "__main__":
    main()
