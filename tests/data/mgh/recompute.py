"""Recomputes the constrained minima of the bounded More-Garbow-Hillstrom problems, independently of the library.

    python recompute.py > recomputed.txt          (needs numpy and scipy)

Every problem is solved by scipy's `least_squares(method="trf")`, with derivatives by complex steps, from its standard
start and from 300 points drawn in the box (wide intervals on a logarithmic scale), then polished by L-BFGS-B. Printed are
the sum of squares from the standard start, the lowest sum found, and where.
"""

import numpy as np
from scipy.optimize import least_squares, minimize

i_ = lambda m: np.arange(1, m + 1)


def helical(x):
    turn = np.arctan(x[1] / x[0]) / (2 * np.pi) + (0.5 if x[0].real < 0 else 0.0)
    return np.array([10 * (x[2] - 10 * turn), 10 * (np.sqrt(x[0] ** 2 + x[1] ** 2) - 1), x[2]])


def gaussian(x):
    h = [0.0009, 0.0044, 0.0175, 0.0540, 0.1295, 0.2420, 0.3521, 0.3989]
    return x[0] * np.exp(-x[1] * ((8 - i_(15)) / 2 - x[2]) ** 2 / 2) - np.array(h + h[6::-1])


def gulf(x, form, m):
    t = i_(m) / 100
    y = 25 + (-50 * np.log(t)) ** (2 / 3)
    d = {"difference": y - x[1], "product": y * 100 * i_(m) * x[1]}[form]
    d = np.where(d.real < 0, -d, d)
    return np.exp(-(d ** x[2]) / x[0]) - t


def box(x):
    t = 0.1 * i_(3)
    return np.exp(-t * x[0]) - np.exp(-t * x[1]) - x[2] * (np.exp(-t) - np.exp(-10 * t))


def wood(x):
    s = np.sqrt
    return np.array([10 * (x[1] - x[0] ** 2), 1 - x[0], s(90) * (x[3] - x[2] ** 2), 1 - x[2],
                     s(10) * (x[1] + x[3] - 2), (x[1] - x[3]) / s(10)])


def brown_dennis(x):
    t = i_(20) / 5
    return (x[0] + t * x[1] - np.exp(t)) ** 2 + (x[2] + x[3] * np.sin(t) - np.cos(t)) ** 2


def biggs(x):
    t = 0.1 * i_(13)
    y = np.exp(-t) - 5 * np.exp(-10 * t) + 3 * np.exp(-4 * t)
    return x[2] * np.exp(-t * x[0]) - x[3] * np.exp(-t * x[1]) + x[5] * np.exp(-t * x[4]) - y


def watson(x):
    t = i_(29) / 29
    slope = sum(j * x[j] * t ** (j - 1) for j in range(1, len(x)))
    value = sum(x[j] * t**j for j in range(len(x)))
    return np.concatenate([slope - value**2 - 1, [x[0], x[1] - x[0] ** 2 - 1]])


def powell_singular(x):
    return np.array([x[0] + 10 * x[1], np.sqrt(5) * (x[2] - x[3]), (x[1] - 2 * x[2]) ** 2,
                     np.sqrt(10) * (x[0] - x[3]) ** 2])


def penalty_1(x):
    return np.concatenate([np.sqrt(1e-5) * (x - 1), [np.sum(x**2) - 0.25]])


def penalty_2(x):
    n, a = len(x), np.sqrt(1e-5)
    i = np.arange(2, n + 1)
    y = np.exp(i / 10) + np.exp((i - 1) / 10)
    return np.concatenate([[x[0] - 0.2], a * (np.exp(x[1:] / 10) + np.exp(x[:-1] / 10) - y),
                           a * (np.exp(x[1:] / 10) - np.exp(-0.1)), [np.sum((n - np.arange(n)) * x**2) - 1]])


def variably_dimensioned(x):
    s = np.sum(i_(len(x)) * (x - 1))
    return np.concatenate([x - 1, [s, s**2]])


def chebyquad(x):
    n, u = len(x), 2 * x - 1
    before, current, out = np.ones_like(u), u, []
    for i in i_(n):
        out.append(np.sum(current) / n + (1 / (i * i - 1) if i % 2 == 0 else 0))
        before, current = current, 2 * u * current - before
    return np.array(out)


PROBLEMS = {
    "rosenbrock": (lambda x: np.array([10 * (x[1] - x[0] ** 2), 1 - x[0]]), [-1.2, 1], [-50, 0], [0.5, 100], 0.25),
    "powell_badly_scaled": (lambda x: np.array([1e4 * x[0] * x[1] - 1, np.exp(-x[0]) + np.exp(-x[1]) - 1.0001]),
                            [0, 1], [0, 1], [1, 9], 0.15125900e-9),
    "brown_badly_scaled": (lambda x: np.array([x[0] - 1e6, x[1] - 2e-6, x[0] * x[1] - 2]),
                           [1, 1], [0, 3e-5], [1e6, 100], 784.0),
    "beale": (lambda x: np.array([y - x[0] * (1 - x[1] ** k) for k, y in ((1, 1.5), (2, 2.25), (3, 2.625))]),
              [1, 1], [0.6, 0.5], [10, 100], 0.0),
    "helical_valley": (helical, [-1, 0, 0], [-100, -1, -1], [0.8, 1, 1], 0.99042212),
    "gaussian": (gaussian, [0.4, 1, 0], [0.398, 1, -0.5], [4.2, 2, 0.1], 0.11279300e-7),
    "gulf (difference, 99)": (lambda x: gulf(x, "difference", 99), [5, 2.5, 0.15], [1e-16, 0, 0], [10] * 3, 0.58281431e-4),
    "gulf (product, 99)": (lambda x: gulf(x, "product", 99), [5, 2.5, 0.15], [1e-16, 0, 0], [10] * 3, 0.58281431e-4),
    "gulf (difference, 3)": (lambda x: gulf(x, "difference", 3), [5, 2.5, 0.15], [1e-16, 0, 0], [10] * 3, 0.58281431e-4),
    "box_three": (box, [0, 10, 20], [0, 5, 0], [2, 9.5, 20], 0.30998153e-5),
    "wood": (wood, [-3, -1, -3, -1], [-100] * 4, [0, 10, 100, 100], 0.15567008e1),
    "brown_dennis": (brown_dennis, [25, 5, -5, -1], [-10, 0, -100, -20], [100, 15, 0, 0.2], 0.88860479e5),
    "biggs": (biggs, [1, 2, 1, 1, 1, 1], [0, 0, 0, 1, 0, 0], [2, 8, 1, 7, 5, 5], 0.53209865e-3),
    "watson": (watson, [0] * 9, [-1e-5, 0, 0, 0, 0, -3, 0, -3, 0], [1e-5, 0.9, 0.1, 1, 1, 0, 4, 0, 2], 0.37401397e-1),
    "powell_singular": (powell_singular, [3, -1, 0, 1], [0.1, -20, -1, -1], [100, 20, 1, 50], 0.1878196e-3),
    "penalty_1": (penalty_1, i_(10), [0, 1, 0, 0, 0, 1, 0, 0, 0, 1], [100] * 10, 0.75625699e1),
    "penalty_2": (penalty_2, [0.5] * 10, [-10, 0.1, 0, 0.05, 0, -10, 0, 0.2, 0, 0], [50] * 9 + [0.5], 0.29442600e-3),
    "variably_dimensioned": (variably_dimensioned, 1 - i_(10) / 10, [0] * 10,
                             [10, 20, 30, 40, 50, 60, 70, 80, 90, 0.5], 0.33741268),
    "chebyquad": (chebyquad, i_(8) / 9, [0, 0, 0.1, 0, 0, 0, 0, 0], [0.04, 0.2, 0.3, 1, 1, 1, 1, 1], 0.3639985e-2),
}


def solve(function, start, lower, upper):
    lower, upper = np.array(lower, float), np.array(upper, float)
    start = np.clip(np.array(start, float), lower, upper)

    def jacobian(x):
        columns = [function(x + 1e-30j * e).imag / 1e-30 for e in np.eye(len(x))]
        return np.array(columns).T

    real = lambda x: function(x.astype(complex)).real
    options = dict(bounds=(lower, upper), xtol=1e-15, ftol=1e-15, gtol=1e-15, x_scale="jac", max_nfev=2000)
    inside = np.clip(start, lower + 1e-10 * (upper - lower), upper - 1e-10 * (upper - lower))
    found = least_squares(real, inside, jacobian, **options).x
    cost = lambda x: np.sum(real(x) ** 2)
    slope = lambda x: 2 * jacobian(x).T @ real(x)
    better = minimize(cost, found, jac=slope, method="L-BFGS-B", bounds=list(zip(lower, upper)),
                      options=dict(ftol=0, gtol=0, maxiter=2000)).x
    return min((cost(x), tuple(x)) for x in (found, better))


if __name__ == "__main__":
    np.seterr(all="ignore")
    for name, (function, start, lower, upper, published) in PROBLEMS.items():
        random = np.random.default_rng(1)
        first = solve(function, start, lower, upper)
        best = first
        for _ in range(300):
            low, high = np.array(lower, float), np.array(upper, float)
            spread = 10 ** random.uniform(-4, 0, len(low))
            centre = np.clip(np.array(start, float), low, high)
            point = centre + spread * (random.uniform(low, high) - centre)
            try:
                best = min(best, solve(function, point, lower, upper))
            except (ValueError, FloatingPointError):
                pass
        where = " ".join(f"{v:.6g}" for v in best[1])
        print(f"{name:22} published {published:.8e} standard {first[0]:.9e} lowest {best[0]:.9e} at {where}", flush=True)
