"""The regressors are regressors of scikit-learn, and the numbers are right."""

import pickle

import numpy as np
import pytest
from sklearn.base import clone
from sklearn.gaussian_process import GaussianProcessRegressor as Theirs
from sklearn.gaussian_process.kernels import RBF, ConstantKernel
from sklearn.model_selection import cross_val_score
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.utils.estimator_checks import parametrize_with_checks

import pushlab
from pushlab import kernels
from pushlab.sklearn import (
    GaussianProcessRegressor,
    RandomFeatureGaussianProcessRegressor,
    SparseGaussianProcessRegressor,
)

REGRESSORS = [
    GaussianProcessRegressor(n_starts=1),
    SparseGaussianProcessRegressor(n_pseudo_inputs=20),
    RandomFeatureGaussianProcessRegressor(n_features=40),
]


@parametrize_with_checks(REGRESSORS)
def test_scikit_learn_finds_a_regressor(estimator, check):
    check(estimator)


@pytest.fixture(scope="module")
def data():
    rng = np.random.default_rng(3)
    x = rng.uniform(-2, 2, (120, 2))
    return x, np.sin(2 * x[:, 0]) + 0.3 * x[:, 1] + 0.1 * rng.standard_normal(120)


def test_with_the_same_hyperparameters_it_is_the_process_of_scikit_learn(data):
    x, y = data
    kernel = kernels.SquaredExponential([0.7, 1.9], signal_variance=1.3)
    ours = GaussianProcessRegressor(kernel, noise_variance=0.01, mean=0.0, learn=False).fit(x, y)
    theirs = Theirs(ConstantKernel(1.3) * RBF([0.7, 1.9]), alpha=0.01, optimizer=None).fit(x, y)
    star = np.linspace(-2, 2, 24).reshape(12, 2)
    mean, covariance = ours.predict(star, return_cov=True)
    expected, of_theirs = theirs.predict(star, return_cov=True)
    # Rounding of a covariance of condition 1e4.
    assert np.allclose(mean, expected, atol=1e-10)
    assert np.allclose(covariance, of_theirs, atol=1e-10)
    assert np.allclose(
        ours.predict(star, return_std=True)[1], np.sqrt(np.diag(covariance)), atol=1e-9
    )
    likelihood = ours.log_marginal_likelihood_value_
    assert likelihood == pytest.approx(theirs.log_marginal_likelihood_value_, abs=1e-8)


@pytest.mark.parametrize("regressor", REGRESSORS, ids=lambda one: type(one).__name__)
def test_noise_is_learnt_and_intervals_hold_what_they_say(regressor, data):
    x, y = data
    fitted = clone(regressor).fit(x, y)
    assert np.sqrt(fitted.hyperparameters_["noise_variance"]) == pytest.approx(0.1, rel=0.3)
    mean, sd = fitted.predict(x, return_std=True, noise=True)
    assert 0.85 < np.mean(np.abs(y - mean) < 1.96 * sd) <= 1.0
    assert (fitted.predict(x, return_std=True)[1] < sd).all()
    again = pickle.loads(pickle.dumps(fitted))
    assert np.array_equal(again.predict(x), mean)
    assert fitted.sample_y(x[:5], 3).shape == (5, 3)
    assert np.array_equal(fitted.sample_y(x[:5], 3), fitted.sample_y(x[:5], 3))


def test_it_stands_in_pipelines(data):
    x, y = data
    chain = make_pipeline(StandardScaler(), GaussianProcessRegressor(n_starts=1))
    assert cross_val_score(chain, x, y, cv=3).mean() > 0.9


def test_hyperparameters_are_fixed_and_bounded_by_name(data):
    x, y = data
    kernel = kernels.Matern52([1.0, 1.0]) + kernels.Constant(0.5)
    fixed = {"matern52.lengthscale": 1.5}
    found = GaussianProcessRegressor(kernel, fixed=fixed, bounds={"noise_variance": (0.04, 1.0)})
    named = found.fit(x, y).hyperparameters_
    assert (
        named["matern52.lengthscale[0]"] == named["matern52.lengthscale[1]"] == pytest.approx(1.5)
    )
    assert named["noise_variance"] == pytest.approx(0.04, rel=1e-2)
    assert "noise_variance" in found.report_
    with pytest.raises(pushlab.PushlabError, match="no_such"):
        GaussianProcessRegressor(fixed={"no_such": 1.0}).fit(x, y)


def test_kernels_are_added_multiplied_and_told():
    kernel = 2.0 * kernels.Periodic(1.5) + kernels.Linear([1.0, 2.0]).active([0, 1])
    assert kernel == 2.0 * kernels.Periodic(1.5) + kernels.Linear([1.0, 2.0]).active([0, 1])
    assert "Periodic(periods=1.5" in repr(kernel) and ".active([0, 1])" in repr(kernel)


def test_every_kernel_is_known_to_the_crate(data):
    x, y = data[0][:20], data[1][:20]
    one = [
        kernels.SquaredExponential(),
        kernels.Matern12(),
        kernels.Matern32(),
        kernels.Matern52(),
        kernels.RationalQuadratic(),
        kernels.Polynomial(2),
        kernels.Periodic(3.0),
        kernels.Cosine(3.0),
        kernels.Linear(),
        kernels.Constant(),
        kernels.White(),
    ]
    for kernel in one:
        fitted = GaussianProcessRegressor(kernel, noise_variance=0.1, learn=False).fit(x, y)
        assert np.isfinite(fitted.predict(x)).all()
    assert {type(kernel).__name__ for kernel in one} == set(kernels.__all__) - {"Kernel"}


def test_what_cannot_be_learnt_is_refused_in_words(data):
    x, y = data
    with pytest.raises(pushlab.PushlabError, match="all"):
        GaussianProcessRegressor().fit(x, np.ones(len(y)))
    with pytest.raises(TypeError, match="pushlab.kernels"):
        GaussianProcessRegressor(kernel="rbf").fit(x, y)
    with pytest.raises(pushlab.PushlabError, match="there are vfe, fitc, dtc"):
        SparseGaussianProcessRegressor(approximation="sor").fit(x, y)
    with pytest.raises(ValueError, match="cannot both"):
        GaussianProcessRegressor(n_starts=1).fit(x, y).predict(x, return_std=True, return_cov=True)
