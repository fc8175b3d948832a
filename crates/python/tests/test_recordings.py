"""Sets become tables, and tables what other libraries have."""

import numpy as np
import pandas
import polars
import pyarrow.parquet
import pytest

import pushlab


def test_a_set_tells_what_was_found(pushes):
    assert len(pushes.recordings) > 5
    assert pushes.name in str(pushes)


def test_columns_are_arrays_with_units_and_meanings(steps):
    assert steps["dx_m"].shape == (steps.n_rows,)
    assert steps["dx_m"].dtype == np.float64
    assert steps["edge"].dtype == np.uint32
    assert steps["recording"].dtype.kind == "U"
    assert steps.units["dtheta_rad"] == "rad"
    assert "pusher's mean velocity" in steps.meanings["beta_rad"] or steps.meanings["beta_rad"]
    assert steps.report.summary.pushes_used > 5
    with pytest.raises(KeyError):
        steps["no_such_column"]


def test_everyone_gets_the_same_array_and_nobody_may_change_it(steps):
    assert steps["dx_m"] is steps["dx_m"]
    with pytest.raises(ValueError, match="read-only"):
        steps["dx_m"][0] = 1.0


def test_the_same_rows_come_as_pandas_polars_and_arrow(steps):
    frames = [steps.to_pandas(), steps.to_polars().to_pandas(), steps.to_arrow().to_pandas()]
    for frame in frames:
        assert list(frame.columns) == steps.columns
        assert np.array_equal(frame["dx_m"], steps["dx_m"])
        assert frame["phase"].astype(str).tolist() == steps["phase"].tolist()
    field = steps.to_arrow().schema.field("speed_m_s")
    assert field.metadata[b"unit"] == b"m/s"
    assert polars.from_arrow(pyarrow.table(steps)).shape == (steps.n_rows, len(steps))


def test_a_table_is_written_and_read_without_loss(steps, pushes, tmp_path):
    for ending in ("csv", "parquet"):
        path = tmp_path / f"steps.{ending}"
        steps.write(path)
        again = pushlab.read_steps(path, manifest=pushes.path / "dataset.toml")
        for name in steps:
            assert np.array_equal(steps[name], again[name], equal_nan=steps[name].dtype.kind == "f")
    assert pyarrow.parquet.read_table(path)["dx_m"].to_numpy().tolist() == steps["dx_m"].tolist()
    assert pandas.read_csv(tmp_path / "steps.csv", comment="#").shape == (steps.n_rows, len(steps))


def test_rows_are_selected_by_masks_and_numbers(steps):
    first = steps.select(steps["push"] == 0)
    assert first.n_rows == (steps["push"] == 0).sum()
    assert steps.select([3, 1])["t_s"].tolist() == steps["t_s"][[3, 1]].tolist()
    with pytest.raises(pushlab.PushlabError, match="there is no row 100000"):
        steps.select([100000])
    with pytest.raises(pushlab.PushlabError, match="a mask has one value a row"):
        steps.select([True, False])
    with pytest.raises(pushlab.PushlabError, match="whole numbers, got float64"):
        steps.select([0.5])
    none = steps.select([])
    assert none.n_rows == 0 and none["dx_m"].shape == (0,)
    with pytest.raises(pushlab.PushlabError, match="there is no row 0: the table has 0"):
        none.select([0])


def test_a_step_has_the_length_that_was_asked_for(pushes):
    short = pushes.ingest(step="100ms", progress=False)
    assert np.median(short["dt_s"]) == pytest.approx(0.1)
    with pytest.raises(pushlab.PushlabError, match="expected a time in s or ms"):
        pushes.ingest(step="4 inches", progress=False)


def test_a_notebook_shows_the_first_rows(steps):
    page = steps._repr_html_()
    assert page.count("<tr>") == 9 and "dtheta_rad" in page


def test_errors_are_those_of_the_command_line(tmp_path):
    with pytest.raises(pushlab.PushlabError, match="no/such/set"):
        pushlab.RecordingSet("no/such/set")
    with pytest.raises(pushlab.PushlabError, match="there is no preset `mine`; there are mit-push"):
        pushlab.RecordingSet(tmp_path, preset="mine")
    with pytest.raises(pushlab.PushlabError, match="help: check the path"):
        pushlab.command("describe", tmp_path / "steps.csv")
    assert issubclass(pushlab.PushlabError, ValueError)
