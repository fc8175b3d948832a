"""Diagnoses many recording sets, one a task of a Dask cluster, and writes a table of the verdicts.

    python sets.py rigs/* -o verdicts --scheduler tcp://head-node:8786

leaves in the folder ``verdicts`` a ``diagnosis.json`` of each set, as ``pushlab diagnose`` writes it for its
nominal model, and ``verdicts.csv``. A set whose diagnosis is there is not diagnosed again.
"""

import argparse
import csv
from pathlib import Path

from dask.distributed import Client, as_completed

import pushlab

# One task a worker, one thread a task: more would wait for each other.
LOCAL = {"threads_per_worker": 1, "env": {"RAYON_NUM_THREADS": "1"}}

COLUMNS = ["set", "verdict", "effects", "error_before", "error_after"]


def diagnose(recordings, output):
    """A row of the table: what the nominal model of a set lacks, or why it cannot be told."""
    row = {"set": recordings.name}
    try:
        if not output.exists():
            model = pushlab.Model.nominal(recordings)
            options = {"model": model.path, "output": output}
            pushlab.command("diagnose", recordings, **options, progress=False)
    except pushlab.PushlabError as error:
        return {**row, "verdict": "refused", "effects": str(error).splitlines()[0]}
    found = pushlab.Diagnosis.read(output)
    effects = " ".join(found.identified or found.effective)
    before, after = found.error.before, found.error.after
    return {**row, "verdict": found.verdict, "effects": effects, "error_before": before, "error_after": after}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recordings", type=Path, nargs="+", help="folders with a dataset.toml each")
    parser.add_argument("-o", "--output", type=Path, required=True, help="a folder, which may be there")
    parser.add_argument("--scheduler", help="address of a cluster; else the processors of this machine")
    given = parser.parse_args()
    folder = given.output.resolve()
    folder.mkdir(exist_ok=True)
    sets = [one.resolve() for one in given.recordings]
    outputs = [folder / f"{one.name}.diagnosis.json" for one in sets]
    if len(set(outputs)) < len(outputs):
        parser.error("two sets have the same name")
    rows = []
    with Client(given.scheduler) if given.scheduler else Client(**LOCAL) as client:
        tasks = client.map(diagnose, sets, outputs, pure=False)
        for _, row in as_completed(tasks, with_results=True):
            print(f"{row['set']}: {row['verdict']} {row['effects']}", flush=True)
            rows.append(row)
    with open(folder / "verdicts.csv", "w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, COLUMNS)
        table.writeheader()
        table.writerows(sorted(rows, key=lambda row: row["set"]))


if __name__ == "__main__":
    main()
