#!/usr/bin/env python3
"""Gaussian processes of Python on a file that `cargo xtask bench gp --peers` wrote.

    python3 peers.py FILE fit|likelihood

Prints one JSON object a line: peer, task, size, seconds of the median of some runs and, for fits,
the mean negative log density of the file's test rows. NumPy and SciPy are used by hand, as LAPACK;
scikit-learn and GPy where they are installed. One thread, if the caller sets OMP_NUM_THREADS and
OPENBLAS_NUM_THREADS to 1.
"""
import json
import sys
import time

import numpy as np
import scipy
from scipy.linalg import lapack
from scipy.optimize import minimize

NAME = f"LAPACK by hand (NumPy {np.__version__}, SciPy {scipy.__version__})"


def read(path):
    """Training and test rows: inputs, N x 2, and outputs, N."""
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    part = lambda split: (table[table[:, 3] == split, :2], table[table[:, 3] == split, 2])
    return part(0), part(1)


def covariance(theta, a, b):
    """The squared exponential; theta holds ln of two lengthscales, signal and noise variance."""
    scaled = [(a[:, d, None] - b[None, :, d]) * np.exp(-theta[d]) for d in range(2)]
    squares = [s * s for s in scaled]
    return np.exp(theta[2] - 0.5 * (squares[0] + squares[1])), squares


def loss(theta, x, y):
    """-ln p(y) at the best constant mean, and its gradient, by dpotrf and dpotri."""
    n = len(y)
    k, squares = covariance(theta, x, x)
    factor = k.copy(order="F")
    factor[np.diag_indices(n)] += np.exp(theta[3])
    factor, info = lapack.dpotrf(factor, lower=1, overwrite_a=1)
    if info:
        return 1e10, np.zeros(4)
    solution, _ = lapack.dpotrs(factor, np.c_[y, np.ones(n)], lower=1)
    weights = solution[:, 0] - solution[:, 0].sum() / solution[:, 1].sum() * solution[:, 1]
    residual = y - solution[:, 0].sum() / solution[:, 1].sum()
    log_determinant = 2 * np.log(np.diag(factor)).sum()
    value = 0.5 * (residual @ weights + log_determinant + n * np.log(2 * np.pi))
    inverse, _ = lapack.dpotri(factor, lower=1, overwrite_c=1)
    slope = np.tril(inverse, -1)
    slope += slope.T
    slope[np.diag_indices(n)] = np.diag(inverse)
    slope -= np.outer(weights, weights)
    of_noise = 0.5 * np.exp(theta[3]) * np.trace(slope)
    slope *= k
    of_lengths = [0.5 * np.vdot(slope, square) for square in squares]
    return value, np.array([*of_lengths, 0.5 * slope.sum(), of_noise])


def predict(theta, x, y, x_star):
    k, _ = covariance(theta, x, x)
    k[np.diag_indices(len(y))] += np.exp(theta[3])
    factor, _ = lapack.dpotrf(np.asfortranarray(k), lower=1)
    ones, _ = lapack.dpotrs(factor, np.ones(len(y)), lower=1)
    mean = ones @ y / ones.sum()
    cross, _ = covariance(theta, x, x_star)
    weights, _ = lapack.dpotrs(factor, y - mean, lower=1)
    half = scipy.linalg.solve_triangular(factor, cross, lower=True)
    return mean + cross.T @ weights, np.exp(theta[2]) + np.exp(theta[3]) - (half * half).sum(0)


def nlpd(y, mean, variance):
    return float(np.mean(0.5 * ((y - mean) ** 2 / variance + np.log(2 * np.pi * variance))))


def median(runs, run):
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        made = run()
        times.append(time.perf_counter() - start)
    return float(np.median(times)), made


def report(peer, task, size, seconds, density=None):
    row = {"peer": peer, "task": task, "size": size, "seconds": seconds, "nlpd": density}
    print(json.dumps(row), flush=True)


def likelihoods(x, y):
    theta = np.log([0.5, 0.7, 0.07, 4e-4])
    runs = {500: 21, 2000: 5}.get(len(y), 1)
    seconds, _ = median(runs, lambda: loss(theta, x, y))
    report(NAME, "likelihood with gradient", len(y), seconds)
    try:
        import sklearn
        from sklearn.gaussian_process import GaussianProcessRegressor
        from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel
    except ImportError:
        return
    if len(y) > 2000:
        return
    kernel = ConstantKernel(0.07) * RBF([0.5, 0.7]) + WhiteKernel(4e-4)
    gp = GaussianProcessRegressor(kernel, optimizer=None).fit(x, y)
    evaluate = lambda: gp.log_marginal_likelihood(gp.kernel_.theta, eval_gradient=True)
    seconds, _ = median(3, evaluate)
    report(f"scikit-learn {sklearn.__version__}", "likelihood with gradient", len(y), seconds)


def fits(train, test):
    (x, y), (x_test, y_test) = train, test
    start = np.log([1.0, 1.0, np.var(y), 0.1 * np.var(y)])
    bounds = [(-5, 5), (-5, 5), (-15, 15), (-20, 5)]
    fit = lambda: minimize(loss, start, args=(x, y), jac=True, method="L-BFGS-B", bounds=bounds)
    seconds, found = median(1, fit)
    report(NAME, "full fit", len(y), seconds, nlpd(y_test, *predict(found.x, x, y, x_test)))
    try:
        import GPy
    except ImportError:
        return
    for m in [20, 50]:
        sparse = lambda: sparse_gpy(GPy, x, y, m)
        seconds, model = median(1, sparse)
        mean, variance = model.predict(x_test)
        task = f"sparse fit, M = {m}"
        density = nlpd(y_test, mean[:, 0], variance[:, 0])
        report(f"GPy {GPy.__version__}", task, len(y), seconds, density)


def sparse_gpy(library, x, y, m):
    """Pseudo-inputs that start at random rows and are optimised with the hyperparameters."""
    rows = np.random.Generator(np.random.PCG64(7)).choice(len(y), m, replace=False)
    kernel = library.kern.RBF(2, ARD=True)
    model = library.models.SparseGPRegression(x, y[:, None], kernel, Z=x[rows].copy())
    model.optimize(max_iters=1000)
    return model


def main():
    path, task = sys.argv[1:]
    train, test = read(path)
    likelihoods(*train) if task == "likelihood" else fits(train, test)


if __name__ == "__main__":
    main()
