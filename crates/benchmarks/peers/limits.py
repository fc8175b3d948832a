#!/usr/bin/env python3
"""A Gaussian process of another library on a file that `cargo xtask bench --limits` wrote.

    python3 limits.py gpytorch-exact|gpytorch-kiss|gpytorch-svgp|gpflow-sgpr FILE

Prints a JSON object: method, learn_seconds, predict_seconds, peak_memory_mb, nlpd of the test rows and
rmse to what they are scored against. One thread, if the caller sets OMP_NUM_THREADS and its like to 1.
"""
import json
import os
import resource
import sys
import time
import warnings

import numpy as np

warnings.filterwarnings("ignore")
M = 100


def read(path):
    numbers = np.fromfile(path, dtype="<f8")
    n, rows = int(numbers[0]), numbers[1:].reshape(-1, 4)
    return rows[:n, :2], rows[:n, 2], rows[n:, :2], rows[n:, 2], rows[n:, 3]


class Gpytorch:
    def __init__(self, method):
        import gpytorch
        import torch

        torch.set_num_threads(int(os.environ.get("OMP_NUM_THREADS", "1")))
        torch.set_default_dtype(torch.float64)
        torch.manual_seed(7)
        self.g, self.torch, self.method = gpytorch, torch, method
        self.name = f"{method.split('-')[1]} (GPyTorch {gpytorch.__version__})"

    def kernel(self):
        return self.g.kernels.ScaleKernel(self.g.kernels.RBFKernel(ard_num_dims=2))

    def learn(self, x, y):
        tensor = self.torch.as_tensor
        self.origin = y.mean()
        x, y = tensor(x), tensor(y - self.origin)
        self.likelihood = self.g.likelihoods.GaussianLikelihood()
        start = {"noise": 0.1 * float(y.var())}
        self.likelihood.initialize(**start)
        getattr(self, self.method.split("-")[1])(x, y)

    def exact(self, x, y, kernel=None, lr=0.1, steps=100):
        g = self.g
        base = kernel or self.kernel()

        class Model(g.models.ExactGP):
            def __init__(self, likelihood):
                super().__init__(x, y, likelihood)
                self.mean_module, self.covar_module = g.means.ConstantMean(), base

            def forward(self, x):
                return g.distributions.MultivariateNormal(self.mean_module(x), self.covar_module(x))

        self.model = Model(self.likelihood)
        loss = g.mlls.ExactMarginalLogLikelihood(self.likelihood, self.model)
        optimizer = self.torch.optim.Adam(self.model.parameters(), lr=lr)
        self.model.train(), self.likelihood.train()
        for _ in range(steps):
            optimizer.zero_grad()
            value = -loss(self.model(x), y)
            value.backward()
            optimizer.step()

    def kiss(self, x, y):
        kernels = self.g.kernels
        inner = kernels.GridInterpolationKernel(
            kernels.RBFKernel(ard_num_dims=2), grid_size=30, num_dims=2
        )
        self.exact(x, y, kernels.ScaleKernel(inner), steps=50)

    def svgp(self, x, y, steps=3000, batch=1000):
        g, torch = self.g, self.torch
        rows = torch.randperm(len(y))[: min(M, len(y) // 2)]
        kernel = self.kernel()

        class Model(g.models.ApproximateGP):
            def __init__(self, z):
                q = g.variational.CholeskyVariationalDistribution(len(z))
                super().__init__(g.variational.VariationalStrategy(self, z, q))
                self.mean_module, self.covar_module = g.means.ConstantMean(), kernel

            def forward(self, x):
                return g.distributions.MultivariateNormal(self.mean_module(x), self.covar_module(x))

        self.model = Model(x[rows].clone())
        loss = g.mlls.VariationalELBO(self.likelihood, self.model, num_data=len(y))
        parameters = [*self.model.parameters(), *self.likelihood.parameters()]
        optimizer = torch.optim.Adam(parameters, lr=0.01)
        self.model.train(), self.likelihood.train()
        for _ in range(steps):
            rows = torch.randint(len(y), (min(batch, len(y)),))
            optimizer.zero_grad()
            value = -loss(self.model(x[rows]), y[rows])
            value.backward()
            optimizer.step()

    def predict(self, x):
        self.model.eval(), self.likelihood.eval()
        with self.torch.no_grad(), self.g.settings.fast_pred_var():
            found = self.likelihood(self.model(self.torch.as_tensor(x)))
            return found.mean.numpy() + self.origin, found.variance.numpy()


class Gpflow:
    def __init__(self, _):
        import gpflow

        self.g = gpflow
        self.name = f"SGPR, M = {M} (GPflow {gpflow.__version__})"

    def learn(self, x, y):
        g = self.g
        self.origin = y.mean()
        rows = np.random.Generator(np.random.PCG64(7)).choice(len(y), min(M, len(y) // 2), replace=False)
        kernel = g.kernels.SquaredExponential(np.var(y), lengthscales=[1.0, 1.0])
        data = (x, y[:, None] - self.origin)
        self.model = g.models.SGPR(data, kernel, x[rows].copy(), noise_variance=0.1 * np.var(y))
        g.optimizers.Scipy().minimize(
            self.model.training_loss, self.model.trainable_variables, options={"maxiter": 1000}
        )

    def predict(self, x):
        mean, variance = self.model.predict_y(x)
        return mean.numpy()[:, 0] + self.origin, variance.numpy()[:, 0]


def main():
    method, path = sys.argv[1:]
    x, y, x_test, y_test, truth = read(path)
    peer = {"gpytorch": Gpytorch, "gpflow": Gpflow}[method.split("-")[0]](method)
    start = time.perf_counter()
    peer.learn(x, y)
    learnt = time.perf_counter()
    mean, variance = peer.predict(x_test)
    row = {
        "method": peer.name,
        "learn_seconds": learnt - start,
        "predict_seconds": time.perf_counter() - learnt,
        "peak_memory_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000,
        "nlpd": float(np.mean(0.5 * ((y_test - mean) ** 2 / variance + np.log(2 * np.pi * variance)))),
        "rmse": float(np.sqrt(np.mean((truth - mean) ** 2))),
    }
    print(json.dumps(row), flush=True)


if __name__ == "__main__":
    main()
