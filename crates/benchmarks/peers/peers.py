#!/usr/bin/env python3
"""Gaussian processes of Python on a file that `cargo xtask bench gp --peers` wrote.

    python3 peers.py FILE LIBRARY TASK

LIBRARY is lapack (NumPy and SciPy by hand), sklearn or gpy; TASK is likelihood, fit or, of gpy,
sparse. Prints JSON objects, one a line: peer, task, size, seconds of the median of some runs and,
for fits, the mean negative log density of the file's test rows; first with null seconds when it
begins. One thread, if the caller sets OMP_NUM_THREADS and OPENBLAS_NUM_THREADS to 1.
"""
import json
import sys
import time

import numpy as np

THETA = np.log([0.5, 0.7, 0.07, 4e-4])


def read(path):
    """Training and test rows: inputs, N x 2, and outputs, N."""
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    part = lambda split: (table[table[:, 3] == split, :2], table[table[:, 3] == split, 2])
    return part(0), part(1)


class Lapack:
    """The squared exponential by dpotrf and dpotri; theta holds ln of two lengthscales, signal and
    noise variance."""

    def __init__(self):
        import scipy
        from scipy import linalg, optimize

        self.linalg, self.optimize = linalg, optimize
        self.name = f"LAPACK by hand (NumPy {np.__version__}, SciPy {scipy.__version__})"

    @staticmethod
    def covariance(theta, a, b):
        scaled = [(a[:, d, None] - b[None, :, d]) * np.exp(-theta[d]) for d in range(2)]
        squares = [s * s for s in scaled]
        return np.exp(theta[2] - 0.5 * (squares[0] + squares[1])), squares

    def loss(self, theta, x, y):
        """-ln p(y) at the best constant mean, and its gradient."""
        lapack, n = self.linalg.lapack, len(y)
        k, squares = self.covariance(theta, x, x)
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

    def predict(self, theta, x, y, x_star):
        lapack = self.linalg.lapack
        k, _ = self.covariance(theta, x, x)
        k[np.diag_indices(len(y))] += np.exp(theta[3])
        factor, _ = lapack.dpotrf(np.asfortranarray(k), lower=1)
        ones, _ = lapack.dpotrs(factor, np.ones(len(y)), lower=1)
        mean = ones @ y / ones.sum()
        cross, _ = self.covariance(theta, x, x_star)
        weights, _ = lapack.dpotrs(factor, y - mean, lower=1)
        half = self.linalg.solve_triangular(factor, cross, lower=True)
        return mean + cross.T @ weights, np.exp(theta[2]) + np.exp(theta[3]) - (half * half).sum(0)

    def likelihood(self, x, y):
        return lambda: self.loss(THETA, x, y)

    def fit(self, x, y):
        start = np.log([1.0, 1.0, np.var(y), 0.1 * np.var(y)])
        bounds = [(-5, 5), (-5, 5), (-15, 15), (-20, 5)]
        minimize = self.optimize.minimize
        found = minimize(self.loss, start, args=(x, y), jac=True, method="L-BFGS-B", bounds=bounds)
        return lambda x_star: self.predict(found.x, x, y, x_star)


class ScikitLearn:
    def __init__(self):
        import sklearn
        from sklearn import gaussian_process

        self.name, self.library = f"scikit-learn {sklearn.__version__}", gaussian_process

    def process(self, lengthscales, signal_variance, noise_variance, **options):
        kernels = self.library.kernels
        kernel = kernels.ConstantKernel(signal_variance) * kernels.RBF(lengthscales)
        kernel += kernels.WhiteKernel(noise_variance, noise_level_bounds=(1e-9, 1e2))
        return self.library.GaussianProcessRegressor(kernel, **options)

    def likelihood(self, x, y):
        gp = self.process([0.5, 0.7], 0.07, 4e-4, optimizer=None).fit(x, y)
        return lambda: gp.log_marginal_likelihood(gp.kernel_.theta, eval_gradient=True)

    def fit(self, x, y):
        origin = y.mean()
        gp = self.process([1.0, 1.0], np.var(y), 0.1 * np.var(y)).fit(x, y - origin)

        def predict(x_star):
            mean, deviation = gp.predict(x_star, return_std=True)
            return mean + origin, deviation**2

        return predict


class Gpy:
    def __init__(self):
        import GPy

        self.name, self.library = f"GPy {GPy.__version__}", GPy

    def likelihood(self, x, y):
        kernel = self.library.kern.RBF(2, 0.07, [0.5, 0.7], ARD=True)
        model = self.library.models.GPRegression(x, y[:, None], kernel, noise_var=4e-4)
        theta = model.optimizer_array.copy()
        # It computes nothing where nothing has changed.
        steps = iter(range(1, 10**9))
        return lambda: model._objective_grads(theta + 1e-9 * next(steps))

    def fit(self, x, y):
        kernel = self.library.kern.RBF(2, np.var(y), [1.0, 1.0], ARD=True)
        noise = 0.1 * np.var(y)
        model = self.library.models.GPRegression(x, y[:, None] - y.mean(), kernel, noise_var=noise)
        model.optimize(max_iters=1000)
        return self.predictor(model, y.mean())

    def sparse(self, x, y, m):
        """Pseudo-inputs that start at random rows and are optimised with the hyperparameters."""
        rows = np.random.Generator(np.random.PCG64(7)).choice(len(y), m, replace=False)
        kernel = self.library.kern.RBF(2, ARD=True)
        z = x[rows].copy()
        model = self.library.models.SparseGPRegression(x, y[:, None] - y.mean(), kernel, Z=z)
        model.optimize(max_iters=1000)
        return self.predictor(model, y.mean())

    @staticmethod
    def predictor(model, origin):
        def predict(x_star):
            mean, variance = model.predict(x_star)
            return mean[:, 0] + origin, variance[:, 0]

        return predict


def nlpd(y, mean, variance):
    return float(np.mean(0.5 * ((y - mean) ** 2 / variance + np.log(2 * np.pi * variance))))


def median(runs, run):
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        made = run()
        times.append(time.perf_counter() - start)
    return float(np.median(times)), made


def report(peer, task, size, seconds=None, density=None):
    row = {"peer": peer, "task": task, "size": size, "seconds": seconds, "nlpd": density}
    print(json.dumps(row), flush=True)


def main():
    path, library, task = sys.argv[1:]
    (x, y), (x_test, y_test) = read(path)
    peer = {"lapack": Lapack, "sklearn": ScikitLearn, "gpy": Gpy}[library]()
    if task == "likelihood":
        name = "likelihood with gradient"
        report(peer.name, name, len(y))
        evaluate = peer.likelihood(x, y)
        evaluate()
        seconds, _ = median({500: 21, 2000: 5}.get(len(y), 1), evaluate)
        report(peer.name, name, len(y), seconds)
        return
    fits = {"full fit": lambda: peer.fit(x, y)}
    if task == "sparse":
        fits = {f"sparse fit, M = {m}": lambda m=m: peer.sparse(x, y, m) for m in [20, 50]}
    for name, fit in fits.items():
        report(peer.name, name, len(y))
        seconds, predict = median(1, fit)
        report(peer.name, name, len(y), seconds, nlpd(y_test, *predict(x_test)))


if __name__ == "__main__":
    main()
