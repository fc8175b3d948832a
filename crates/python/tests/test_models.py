"""Models predict tables, learn, and change by what is found."""

import numpy as np
import pytest

import pushlab


def test_a_prediction_is_a_gaussian_for_each_step_in_contact(nominal, steps):
    found = nominal.predict(steps)
    n = len(found.rows)
    assert found.mean.shape == (n, 3) and found.covariance.shape == (n, 3, 3)
    assert (steps["phase"][found.rows] == "contact").all()
    observed = np.column_stack([steps[name][found.rows] for name in ("dx_m", "dy_m", "dtheta_rad")])
    rms = np.sqrt(np.mean((observed - found.mean) ** 2, axis=0))
    # A step is some millimetres long.
    assert (rms[:2] < 1e-3).all() and rms[2] < 0.02
    assert np.array_equal(found.covariance, found.covariance.transpose(0, 2, 1))


def test_a_part_of_a_table_is_predicted_as_the_whole(nominal, steps):
    whole = nominal.predict(steps)
    some = nominal.predict(steps.select(whole.rows[:40]))
    assert np.array_equal(some.mean, whole.mean[:40])


def test_progress_is_told_to_a_function(nominal, steps):
    told = []
    nominal.predict(steps, progress=lambda *said: told.append(said))
    n = len(nominal.predict(steps).rows)
    assert told[-1] == ("steps predicted:", n, n)


def test_a_table_without_a_manifest_is_refused(nominal, steps, tmp_path):
    steps.write(tmp_path / "steps.csv")
    bare = pushlab.read_steps(tmp_path / "steps.csv")
    with pytest.raises(pushlab.PushlabError, match="read it with manifest="):
        nominal.predict(bare)


def test_a_model_is_saved_and_not_overwritten(nominal, tmp_path):
    path = tmp_path / "model.toml"
    saved = nominal.save(path)
    assert saved.name == nominal.name and pushlab.Model(path).text == nominal.text
    with pytest.raises(pushlab.PushlabError, match="exists"):
        nominal.save(path)
    nominal.save(path, replace=True)


def test_effects_are_added_by_hand(nominal, steps):
    tilted = pushlab.add(nominal, "table-tilt", values={"ax": 0.05, "ay": 0.0}).model
    assert tilted.effects == ["table-tilt"] and nominal.effects == []
    moved = tilted.predict(steps).mean - nominal.predict(steps).mean
    assert np.abs(moved).max() > 1e-5
    with pytest.raises(pushlab.PushlabError, match="table-tilts"):
        pushlab.add(nominal, "table-tilts", values={"ax": 0.05})


def test_a_learnt_model_predicts_with_its_uncertainty(tilted):
    made = pushlab.train(tilted, "gp", rows=120, progress=False)
    assert [score.name for score in made.unseen.scores] == ["dx", "dy", "dtheta"]
    steps = tilted.ingest(progress=False)
    found = made.model.predict(steps)
    assert (np.linalg.eigvalsh(found.covariance) > 0).all()
    without = made.model.predict(steps, noise=False)
    assert (without.sd < found.sd).all() and np.array_equal(without.mean, found.mean)


def test_fits_say_what_they_found(tilted, nominal):
    made = pushlab.fit(tilted, pushlab.Model.nominal(tilted), "pusher-friction", progress=False)
    assert "pusher" in str(made) and "wrote" not in str(made)
    assert made.model.name
    assert made.document.schema == "pushlab.fit/1"
    steps = tilted.ingest(progress=False)
    assert set(made.model.held_out) < set(steps.pushes)
    assert pushlab.Model.nominal(tilted).held_out == []
