"""One step of 10^4 particles by a sparse Gaussian process of 80 pseudo-inputs, straightforwardly in
NumPy: contact of a round pusher with a square, three outputs with their full variance, a draw, a move.
Prints the median time of a step, in s."""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import time

import numpy as np

N, M, HALF, RADIUS = 10_000, 80, 0.045, 0.005
random = np.random.default_rng(7)
pseudo = random.uniform([0.0, -0.7], [1.0, 0.7], (M, 2))
weights = random.normal(size=(3, M))
lengths = np.array([[0.5, 0.7], [0.4, 0.6], [0.6, 0.5]])
roots = np.stack([np.tril(random.normal(size=(M, M))) / M for _ in range(3)])
start, end = np.array([-HALF - RADIUS, 0.01]), np.array([-HALF - RADIUS + 0.004, 0.011])
poses = random.normal([0.0, 0.0, 0.0], [1e-4, 1e-4, 5e-3], (N, 3))


def step(poses):
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    off = start - poses[:, :2]
    body = np.stack([cos * off[:, 0] + sin * off[:, 1], cos * off[:, 1] - sin * off[:, 0]], axis=1)
    p = np.clip((HALF - body[:, 1]) / (2.0 * HALF), 0.0, 1.0)
    way = end - start
    beta = np.arctan2(way[1], way[0]) - poses[:, 2]
    inputs = np.stack([p, beta], axis=1)
    distance = np.hypot(*way)
    moves = np.empty((N, 3))
    for k in range(3):
        scaled, centers = inputs / lengths[k], pseudo / lengths[k]
        squares = ((scaled[:, None, :] - centers[None, :, :]) ** 2).sum(axis=2)
        kernel = np.exp(-0.5 * squares)
        mean = kernel @ weights[k]
        variance = 1.01 - np.clip(((kernel @ roots[k]) ** 2).sum(axis=1), 0.0, 1.0)
        moves[:, k] = distance * (mean + np.sqrt(variance) * random.normal(size=N))
    along = way / distance
    moved = poses.copy()
    moved[:, 0] += moves[:, 0] * along[0] - moves[:, 1] * along[1]
    moved[:, 1] += moves[:, 0] * along[1] + moves[:, 1] * along[0]
    moved[:, 2] += moves[:, 2]
    return moved


times = []
for _ in range(7):
    began = time.perf_counter()
    step(poses)
    times.append(time.perf_counter() - began)
print(sorted(times)[3])
