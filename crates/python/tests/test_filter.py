"""The particle filter against the Kalman filter, and its other laws."""

import numpy as np
import pytest

import pushlab

DRIFT, MOTION_SD, SENSOR_SD = 0.3, 0.4, 0.5
SEEN = [0.5, 0.9, 0.8, 1.6]


def walk(states, rng):
    return states + DRIFT + MOTION_SD * rng.standard_normal(states.shape)


def seen(value):
    return lambda states: -0.5 * ((states[:, 0] - value) / SENSOR_SD) ** 2


def filtered(**settings):
    start = np.random.default_rng(1).standard_normal((20_000, 1))
    particles = pushlab.ParticleFilter(start, **settings)
    updates = []
    for value in SEEN:
        particles.predict(walk)
        updates.append(particles.update(seen(value)))
    return particles, updates


def kalman():
    mean, variance = 0.0, 1.0
    for value in SEEN:
        mean, variance = mean + DRIFT, variance + MOTION_SD**2
        gain = variance / (variance + SENSOR_SD**2)
        mean, variance = mean + gain * (value - mean), (1 - gain) * variance
    return mean, variance


@pytest.mark.parametrize("resampler", ["systematic", "stratified", "residual", "multinomial"])
def test_a_linear_gaussian_case_meets_the_kalman_filter(resampler):
    particles, updates = filtered(resampler=resampler, resample_below=0.9)
    mean, variance = kalman()
    # Five standard errors of 20 000 particles, of which half count.
    assert particles.mean()[0] == pytest.approx(mean, abs=5 * np.sqrt(variance / 10_000))
    assert particles.covariance()[0, 0] == pytest.approx(variance, rel=0.1)
    assert any(update.resampled for update in updates)
    assert particles.step == len(SEEN) and particles.weights.sum() == pytest.approx(1.0)


def test_the_same_seed_gives_the_same_particles():
    one, other, third = filtered(), filtered(), filtered(seed=8)
    assert np.array_equal(one[0].particles, other[0].particles)
    assert not np.array_equal(one[0].particles, third[0].particles)


def test_likelihoods_may_be_numbers():
    particles, again = filtered()[0], filtered()[0]
    states = particles.particles
    assert particles.update(seen(2.0)) == again.update(seen(2.0)(states))
    assert np.array_equal(particles.weights, again.weights)


def test_what_a_motion_raises_is_raised():
    particles = pushlab.ParticleFilter(np.zeros((3000, 2)))

    def broken(states, rng):
        raise KeyError("lost")

    with pytest.raises(KeyError, match="lost"):
        particles.predict(broken)
    with pytest.raises(pushlab.PushlabError, match="returned an array of shape"):
        particles.predict(lambda states, rng: states[:, :1])


def test_bad_input_is_refused_in_words():
    with pytest.raises(pushlab.PushlabError, match=r"shape \(3,\)"):
        pushlab.ParticleFilter(np.zeros(3))
    with pytest.raises(pushlab.PushlabError, match="there is no resampler `wheel`"):
        pushlab.ParticleFilter(np.zeros((3, 1)), resampler="wheel")
    with pytest.raises(pushlab.PushlabError, match="resample_below must be from 0 to 1, got 2"):
        pushlab.ParticleFilter(np.zeros((3, 1)), resample_below=2.0)
    particles = pushlab.ParticleFilter(np.zeros((3, 1)))
    with pytest.raises(pushlab.PushlabError, match="likelihood zero"):
        particles.update(np.full(3, -np.inf))
    with pytest.raises(pushlab.PushlabError, match="expected 3, got 2"):
        particles.update(np.zeros(2))
