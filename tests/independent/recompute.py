#!/usr/bin/env python3
"""The figures of `trammel report --json`, recomputed from a campaign's exported readings.

    recompute.py FOLDER REPORT.json [PROTOCOL.json]

Written from the equations (core/README.md; Zhang et al. 2024, its errata corrected) with numpy and nothing of
Trammel's: kinematics, least squares, both maps, circles, summaries, the model's gap. What is summed must agree to
1e-9, what an optimiser or an ill-conditioned system decides to 1e-6, both relative to the figure's own size where
that is above 1. Ends with 1 and the differences where some are found; prints how many figures were compared.
"""
import csv
import json
import math
import re
import sys

import numpy as np

EXACT, SOLVED = 1e-9, 1e-6
AVERAGED = 0.01  # of its standard deviation: what other sets of effects may add to a value of the named set
differences, compared = [], 0


def same(where, printed, own, tolerance=EXACT):
    global compared
    compared += 1
    if printed is None or not abs(printed - own) <= tolerance * max(1.0, abs(own)):
        differences.append(f"{where}: printed {printed!r}, recomputed {own!r}")


# The mechanism: |C_i - B_i| = S_i, B_i = (l_i + l_zero_i - R_i) u_i + h_i n_i, C_i = O_C + r_i (cos, sin)(beta_i + phi)

ALPHA, BETA, RADIUS, LINK, ZERO, START, OFFSET = range(7)  # rows of a geometry, a column for each chain
NAMES = [f"{n}_{i}" for i in (1, 2, 3) for n in ("alpha", "beta", "r", "S", "l", "R")] + ["h_1", "h_2", "h_3"]
PLACES = [(row, i) for i in range(3) for row in range(6)] + [(OFFSET, i) for i in range(3)]
TOLERANCE = np.array([math.radians(0.05) if row in (ALPHA, BETA) else 0.1 for row, _ in PLACES])


def geometry_of(mechanism):
    g = np.zeros((7, 3))
    for i, c in enumerate(mechanism["chains"]):
        g[:, i] = (math.radians(c["alpha_deg"]), math.radians(c["beta_deg"]), c["r_mm"], c["S_mm"],
                   c.get("l_mm", 0.0), c["R_mm"], c.get("h_mm", 0.0))
    return g


def moved(g, values):
    g = g.copy()
    for (row, i), value in zip(PLACES, values):
        g[row, i] += value
    return g


def along(angle):
    return np.stack([np.cos(angle), np.sin(angle)], -1)


def across(angle):
    return np.stack([-np.sin(angle), np.cos(angle)], -1)


def joints(g, pose):
    return pose[:, None, :2] + g[RADIUS][None, :, None] * along(g[BETA] + pose[:, 2:])


def inverse(g, pose):
    """l of each chain; of the two roots the one on the working mode's side (B behind C along the rail)."""
    C = joints(g, pose)
    beside = (C * across(g[ALPHA])).sum(-1) - g[OFFSET]
    return (C * along(g[ALPHA])).sum(-1) - np.sqrt(g[LINK] ** 2 - beside**2) + g[START] - g[ZERO]


def closure(g, l, pose):
    """C - B of each chain, and f = |C - B|^2 / 2 - S^2 / 2 with df / dX."""
    B = (l + g[ZERO] - g[START])[:, :, None] * along(g[ALPHA]) + g[OFFSET][None, :, None] * across(g[ALPHA])
    D = joints(g, pose) - B
    turned = (D * across(g[BETA] + pose[:, 2:])).sum(-1) * g[RADIUS]
    return D, ((D**2).sum(-1) - g[LINK] ** 2) / 2, np.stack([D[..., 0], D[..., 1], turned], -1)


def forward(g, l, start):
    pose = np.broadcast_to(start, (len(l), 3)).copy()
    for _ in range(50):
        _, f, F_X = closure(g, l, pose)
        step = np.linalg.solve(F_X, f[..., None])[..., 0]
        pose -= step
        if np.abs(step).max() < 1e-14:
            break
    return pose


def error_jacobian(g, l, pose):
    """dX / d(alpha_1, beta_1, … R_3, h_1, h_2, h_3): -F_X^-1 F_p.                                        (18, 19)"""
    D, _, F_X = closure(g, l, pose)
    reach = l + g[ZERO] - g[START]
    u, n = along(g[ALPHA]), across(g[ALPHA])
    Du, Dn = (D * u).sum(-1), (D * n).sum(-1)
    F = {ALPHA: -(reach * Dn - g[OFFSET] * Du), BETA: F_X[..., 2], RADIUS: (D * along(g[BETA] + pose[:, 2:])).sum(-1),
         LINK: -np.broadcast_to(g[LINK], Du.shape), ZERO: -Du, START: Du, OFFSET: -Dn}
    columns = np.zeros((len(l), 3, len(PLACES)))
    for k, (row, i) in enumerate(PLACES):
        columns[:, i, k] = F[row][:, i]
    return -np.linalg.solve(F_X, columns)


# Readings

class Readings:
    def __init__(self, rows):
        def numbers(*names):
            return np.array([[float(row[n]) for n in names] for row in rows]).reshape(-1, 3)

        def poses(*names):
            return numbers(*names) * [1, 1, math.radians(1)]
        self.target = poses("target_x_mm", "target_y_mm", "target_phi_deg")
        self.measured = poses("x_mm", "y_mm", "phi_deg")
        self.cmd = numbers("cmd_l1_mm", "cmd_l2_mm", "cmd_l3_mm")
        self.origin = numbers("from_l1_mm", "from_l2_mm", "from_l3_mm")


def turn(angle):
    return (angle + math.pi) % (2 * math.pi) - math.pi


def errors(pose, target):
    return {"position": np.hypot(*(pose - target)[:, :2].T), "attitude": np.degrees(np.abs(turn((pose - target)[:, 2])))}


def quantile95(values):
    v, h = sorted(values), 0.95 * (len(values) - 1)
    k = int(h)
    return v[k] if k + 1 == len(v) else v[k] + (h - k) * (v[k + 1] - v[k])


def same_summary(where, printed, values, tolerance):
    own = {"mean": math.fsum(values) / len(values), "max": max(values), "min": min(values), "p95": quantile95(values)}
    for name, value in own.items():
        same(f"{where} {name}", printed[name], value, tolerance)
    same(f"{where} n", printed["n"], len(values), 0)
    return own["mean"]


def same_before_after(where, table, before, after, tolerance=EXACT):
    was = same_summary(where + " before", table["before"], before, EXACT)
    left = same_summary(where + " after", table["after"], after, tolerance)
    same(where + " improvement_pct", table["improvement_pct"], 100 * (1 - left / was), tolerance)


# The paper's three methods

def fit_lsq(nominal, r, sigma, columns=18, steps=60):
    """Gauss-Newton of (21) in the directions that the first system determines (s >= 0.05, columns in tolerances)."""
    W, T = 1 / sigma, TOLERANCE[:columns]
    total, V = np.zeros(columns), None
    for step in range(steps):
        g = moved(nominal, total * T)
        at = forward(g, r.cmd, r.target)
        left = r.measured - at
        left[:, 2] = turn(left[:, 2])
        b = (left * W).ravel()
        A = (error_jacobian(g, r.cmd, at)[..., :columns] * W[None, :, None]).reshape(-1, columns) * T
        if V is None:
            _, s, Vt = np.linalg.svd(A, full_matrices=False)
            rank = int((s >= 0.05).sum())
            V, null = Vt[:rank].T, np.linalg.svd(A)[2][rank:]
            covariance = (V / s[:rank] ** 2) @ V.T * np.outer(T, T)
        z = V @ np.linalg.lstsq(A @ V, b, rcond=None)[0]
        total += z
        if np.abs(z).max() < 1e-11:
            break
    chi2 = float(b @ b)
    return dict(values=total * T, geometry=moved(nominal, total * T), rank=rank, null=null * T, covariance=covariance,
                ratio=math.sqrt(chi2 / (len(b) - rank)), null_in_tolerances=null)


def after_lsq(nominal, g, r, home):
    """X' = forward(l(target) + l(measured) - l(expected)), nominal kinematics."""
    expected = forward(g, r.cmd, home)
    return forward(nominal, inverse(nominal, r.target) + inverse(nominal, r.measured) - inverse(nominal, expected), r.target)


def samples(nominal, r):
    """Steps 2 and 6 of Sec. 4.2: e = l(measured) - l commanded, at the targets."""
    return r.target[:, :2], inverse(nominal, r.measured) - r.cmd


def idw(at, places, e):
    """(22): weights 1 / d^2 over all samples; on a sample the sample."""
    d2 = ((at[:, None] - places[None]) ** 2).sum(-1)
    on = d2 < 1e-24
    w = 1 / np.where(on, 1, d2)
    w = np.where(on.any(1)[:, None], on, w)
    return (w @ e) / w.sum(1)[:, None]


class Mersenne64:
    """mt19937_64 (Matsumoto and Nishimura), seeded as C++ seeds it."""
    def __init__(self, seed):
        self.s, self.at = [seed], 312
        for i in range(1, 312):
            self.s.append((6364136223846793005 * (self.s[-1] ^ self.s[-1] >> 62) + i) % 2**64)

    def __call__(self):
        if self.at == 312:
            for i in range(312):
                x = (self.s[i] & ~0x7FFFFFFF) | (self.s[(i + 1) % 312] & 0x7FFFFFFF)
                self.s[i] = self.s[(i + 156) % 312] ^ x >> 1 ^ (0xB5026F5AA96619E9 if x & 1 else 0)
            self.at = 0
        x = self.s[self.at]
        self.at += 1
        x ^= x >> 29 & 0x5555555555555555
        x ^= x << 17 & 0x71D67FFFEDA60000
        x ^= x << 37 & 0xFFF7EEE000000000
        return x ^ x >> 43


def stream(seed, purpose):
    """The generator of one purpose (core/statistics/random.hpp): FNV-1a of its name, mixed by splitmix64."""
    def split(z):
        z = (z + 0x9E3779B97F4A7C15) % 2**64
        z = ((z ^ z >> 30) * 0xBF58476D1CE4E5B9) % 2**64
        z = ((z ^ z >> 27) * 0x94D049BB133111EB) % 2**64
        return z ^ z >> 31
    h = 0xCBF29CE484222325
    for c in purpose.encode():
        h = ((h ^ c) * 0x100000001B3) % 2**64
    return Mersenne64(split(split(split(seed) ^ h)))


def kmeans(p, k, seed=1):
    """k-means++ and Lloyd's steps until no point changes its centre."""
    draw = stream(seed, "kmeans")
    value = draw()
    while value >= 2**64 - 1 - len(p) and value >= 2**64 - 1 - (2**64 - 1) % len(p):
        value = draw()
    c, nearest = [p[value % len(p)]], np.full(len(p), np.inf)
    while len(c) < k:
        nearest = np.minimum(nearest, ((p - c[-1]) ** 2).sum(1))
        left = (draw() >> 11) * 2.0**-53 * math.fsum(nearest)
        for i in np.flatnonzero(nearest > 0):
            pick, left = i, left - nearest[i]
            if left < 0:
                break
        c.append(p[pick])
    c, owner = np.array(c), None
    for _ in range(300):
        now = ((p[:, None] - c[None]) ** 2).sum(-1).argmin(1)
        if owner is not None and (now == owner).all():
            break
        owner, d2 = now, ((p - c[now]) ** 2).sum(1)
        c = np.array([p[owner == j].mean(0) if (owner == j).any() else p[d2.argmax()] for j in range(k)])
    return c


def train_rbf(places, e, neurons=50, ridge=1e-8):
    """(23, 24): ridge least squares with a bias; of 25 spreads that with the least leave-one-out residuals."""
    c = kmeans(places, neurons)
    d2 = ((places[:, None] - c[None]) ** 2).sum(-1)
    best = None
    for sigma in 10 * 64 ** (np.arange(25) / 24):
        Phi = np.c_[np.exp(-d2 / sigma**2), np.ones(len(places))]
        keep = np.full(neurons + 1, math.sqrt(ridge * (Phi**2).sum() / (neurons + 1)))
        keep[-1] = 0
        Q, R = np.linalg.qr(np.r_[Phi, np.diag(keep)])  # of the normal equations, without squaring their condition
        w = np.linalg.solve(R, Q[:len(places)].T @ e)
        left = e - Phi @ w
        loo = left / (1 - (Q[:len(places)] ** 2).sum(1))[:, None]
        score = (loo**2).sum()
        if best is None or score < best[0]:
            best = (score, sigma, w, Phi @ w)
    _, sigma, w, fitted = best
    return dict(sigma=sigma, fitted=fitted,
                at=lambda q: np.c_[np.exp(-((q[:, None] - c[None]) ** 2).sum(-1) / sigma**2), np.ones(len(q))] @ w)


def commanded_by_map(nominal, target, error_at):
    """cmd = l(target) - e, looked up at the target, then where that command stands."""
    l = inverse(nominal, target)
    first = l - error_at(target[:, :2])
    return l - error_at(forward(nominal, first, target)[:, :2])


# Circles, statistics, the model

def fit_circle(p):
    """Least sum of squared radial distances: algebraic start, then Gauss-Newton."""
    m = p.mean(0)
    q = p - m
    a, b, c = np.linalg.lstsq(np.c_[q, np.ones(len(q))], (q**2).sum(1), rcond=None)[0]
    x = np.array([a / 2, b / 2, math.sqrt(c + (a * a + b * b) / 4)])
    for _ in range(50):
        d = q - x[:2]
        rho = np.hypot(*d.T)
        x = x + np.linalg.lstsq(np.c_[d / rho[:, None], np.ones(len(q))], rho - x[2], rcond=None)[0]
    return np.array([m[0] + x[0], m[1] + x[1], x[2]])


def student(level, dof):
    """t with P(|T| > t) = level: bisection on the distribution's integral (Simpson, theta = atan(t / sqrt(dof)))."""
    total = math.exp(math.lgamma(dof / 2) + math.lgamma(0.5) - math.lgamma((dof + 1) / 2))  # of cos^(dof - 1)

    def tail(t):
        theta = np.linspace(math.atan(t / math.sqrt(dof)), math.pi / 2, 20001)
        y = np.cos(theta) ** (dof - 1)
        return 2 * (theta[1] - theta[0]) / 3 * (y[0] + y[-1] + 4 * y[1::2].sum() + 2 * y[2:-1:2].sum()) / total
    low, high = 0.0, 1000.0
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if tail(middle) > level else (low, middle)
    return low


def effect_columns(name, r, home_l, lead):
    """Displacement errors per parameter: readings x rails x parameters."""
    s, n = r.cmd - home_l, len(r.cmd)
    way = r.cmd - r.origin
    waves = [np.sin(2 * math.pi * r.cmd / lead), np.cos(2 * math.pi * r.cmd / lead)]
    per_rail = {"lead_scale": [s], "lead_curvature": [s**2], "backlash": [-0.5 * np.sign(np.where(np.abs(way) > 1e-9, way, 0))],
                "screw_periodic": waves}[name]
    out = np.zeros((n, 3, 3 * len(per_rail)))
    for i in range(3):
        for k, basis in enumerate(per_rail):
            out[:, i, len(per_rail) * i + k] = basis[:, i]
    return out


USUAL = {"lead_scale": 1e-2, "lead_curvature": 2e-5, "backlash": 0.5, "screw_periodic": 0.1}


class Model:
    """The base of 21 and named effects, fitted by Gauss-Newton; what carries less than 0.05 stays at the start."""
    def __init__(self, nominal, home, home_l, lead, effects=()):
        self.nominal, self.home, self.home_l, self.lead, self.effects = nominal, home, home_l, lead, list(effects)
        self.scale = np.r_[TOLERANCE, np.repeat([USUAL[e] for e in effects],
                                                [6 if e == "screw_periodic" else 3 for e in effects])]
        self.z = np.zeros(len(self.scale))

    def dl(self, r):
        return np.concatenate([np.zeros((len(r.cmd), 3, 0))] + [effect_columns(e, r, self.home_l, self.lead) for e in self.effects], -1)

    def predict(self, r):
        v = self.z * self.scale
        g, basis = moved(self.nominal, v[:21]), self.dl(r)
        l = r.cmd + basis @ v[21:]
        return g, l, basis, forward(g, l, self.home)

    def fit(self, r, sigma):
        start = self.z.copy()
        for _ in range(60):
            g, l, basis, at = self.predict(r)
            left = r.measured - at
            left[:, 2] = turn(left[:, 2])
            J = error_jacobian(g, l, at)
            J = np.concatenate([J, np.einsum("nij,njk->nik", J[..., [4, 10, 16]], basis)], -1)
            J = (J * self.scale / sigma[None, :, None]).reshape(-1, len(self.z))
            U, s, Vt = np.linalg.svd(J, full_matrices=False)
            k = int((s >= 0.05).sum())
            V = Vt[:k].T
            away = self.z - start
            step = V @ ((U[:, :k].T @ (left / sigma).ravel()) / s[:k]) - (away - V @ (V.T @ away))
            self.z = self.z + step
            if np.abs(step).max() < 1e-11:
                break
        return self

    def rms(self, r):
        left = (r.measured - self.predict(r)[3])[:, :2]
        return math.sqrt((left**2).mean())


# The report, table by table

def check(folder, report, protocol):
    campaign = json.load(open(f"{folder}/campaign.json"))
    rows = list(csv.DictReader(open(f"{folder}/{campaign['readings']}", newline="")))
    column = "session" if "session" in rows[0] else "x_session"
    session = {}
    for row in rows:
        session.setdefault(row[column], []).append(row)
    R = {name: Readings(of) for name, of in session.items()}
    m, home = campaign["mechanism"], np.array([campaign["mechanism"]["home"][k] for k in ("x_mm", "y_mm", "phi_deg")])
    home = home * [1, 1, math.radians(1)]
    nominal = geometry_of(m)
    lead = m["screw_lead_mm"] if "screw_lead_mm" in m else m["drives"][0]["lead_mm"]
    home_l = inverse(nominal, home[None])
    sigma = np.array([campaign["tracker"]["sigma_xy_mm"]] * 2 + [math.radians(campaign["tracker"]["sigma_phi_deg"])])
    steps = {s["name"]: s for s in protocol["steps"]}
    method_of = {s["name"]: s.get("compensate", "") for s in protocol["steps"]}
    kind = {name: steps[job].get("method", "model") for name, job in method_of.items() if job}

    same("n_readings", report["n_readings"], len(rows), 0)
    for s in report["sessions"]:
        same(f"readings of {s['name']}", s["n_readings"], len(session[s["name"]]), 0)
    same("floor_mean_mm", report["floor_mean_mm"], sigma[0] * math.sqrt(math.pi / 2))
    same("floor_mean_deg", report["floor_mean_deg"], math.degrees(sigma[2]) * math.sqrt(2 / math.pi))

    fitted = R["measure-80"]
    lsq = fit_lsq(nominal, fitted, sigma)
    places, e = samples(nominal, fitted)
    network = train_rbf(places, e)
    maps = {"idw": lambda q: idw(q, places, e), "rbf": network["at"]}

    def is_fitted(targets):
        d = targets[:, None] - fitted.target[None]
        return ((np.hypot(d[..., 0], d[..., 1]) < 1e-3) & (np.abs(d[..., 2]) < 1e-5)).any(1)

    # What was commanded under a correction is the correction's own figure.
    for name, method in kind.items():
        if name not in R or method == "model":
            continue
        r = R[name]
        own = inverse(lsq["geometry"], r.target) if method == "lsq" else commanded_by_map(nominal, r.target, maps[method])
        tolerance = EXACT if method == "idw" else SOLVED
        same(f"commands of {name}", 0.0, float(np.abs(own - r.cmd).max()), tolerance)

    def before_after(method, plan):
        """Measured again under the method; else what lsq predicts."""
        base = R[plan]
        for name, m_ in kind.items():
            if m_ == method and name in R and np.array_equal(R[name].target, base.target):
                return base, R[name].measured, "measured", EXACT
        assert method == "lsq", method
        return base, after_lsq(nominal, lsq["geometry"], base, home), "predicted", SOLVED

    left = {}
    for t in report["tables"]:
        if t["id"] == "circles":
            base, after, how, _ = before_after(t["method"], "circles")
            seen = is_fitted(base.target)
            for part in [t] + t.get("others", []):
                pick = seen if part["judged"] == "in-sample" else ~seen
                same_before_after(f"circles {part['judged']}", part, errors(base.measured, base.target)["position"][pick],
                                  errors(after, base.target)["position"][pick])
            centres = np.round([[c["x_mm"], c["y_mm"]] for c in t["circles"]], 6)
            owner, offs = np.arange(len(base.target)) // (len(base.target) // len(centres)), []
            for k, c in enumerate(t["circles"]):
                pick = owner == [i for i in range(len(centres)) if np.allclose(fit_circle(base.target[owner == i, :2])[:2], centres[k], atol=1e-6)][0]
                wanted = fit_circle(base.target[pick, :2])
                row = []
                for side, pose in (("before", base.measured), ("after", after)):
                    d = fit_circle(pose[pick, :2]) - wanted
                    row.append(d)
                    for key, value in zip(("centre_x_mm", "centre_y_mm", "radius_mm"), d):
                        same(f"circle {c['name']} {side} {key}", c[side][key], value)
                offs.append(row)
            for j, side in enumerate(("mean_abs_before", "mean_abs_after")):
                for key, value in zip(("centre_x_mm", "centre_y_mm", "radius_mm"), np.abs(offs)[:, j].mean(0)):
                    same(f"circles {side} {key}", t[side][key], value)
            continue
        plan = "measure-80" if t["set"] == "identify" else "measure-48"
        base, after, how, tolerance = before_after(t["method"], plan)
        if t["after_is"] != how:
            differences.append(f"{t['id']}: printed {t['after_is']}, there is {how}")
        if t["in_sample"] != bool(is_fitted(base.target).all()) or is_fitted(base.target).any() != is_fitted(base.target).all():
            differences.append(f"{t['id']}: in_sample")
        was, now = errors(base.measured, base.target)[t["figure"]], errors(after, base.target)[t["figure"]]
        same_before_after(t["id"], t, was, now, tolerance)
        if t["figure"] == "position":
            left[t["method"], plan] = now
        if "demand" in t:
            floor, d = sigma[0] * math.sqrt(math.pi / 2), t["demand"]
            perfect = 100 * (1 - floor / was.mean())
            same(f"{t['id']} perfect", d["perfect_improvement_pct"], perfect)
            reached = (100 * (1 - now.mean() / was.mean()) >= 90 or perfect < 90) and now.mean() <= 1.3 * floor
            if reached != d["reached"]:
                differences.append(f"{t['id']}: reached")

    c = report["contest"]
    d = left[c["a"], "measure-48"] - left[c["b"], "measure-48"]
    same("contest n", c["n"], len(d), 0)
    same("contest b_better", c["b_better"], int((d > 0).sum()), 0)
    same("contest difference", c["mean_difference_mm"], d.mean())
    same("contest half width", c["half_width_95_mm"], student(0.05, len(d) - 1) * d.std(ddof=1) / math.sqrt(len(d)))

    check_identification(report["identification"], lsq)
    check_simulation(report["simulation"], nominal, lsq["geometry"], home, [R["measure-80"], R["measure-48"]])
    n = report["network"]
    same("network sigma", n["sigma_mm"], network["sigma"])
    wrong = network["fitted"] - e
    same("network mae", n["mae_mm"], np.abs(wrong).mean(), SOLVED)
    same("network mse", n["mse_mm2"], (wrong**2).mean(), SOLVED)
    for i in range(3):
        same("network r2", n["r2"][i], 1 - (wrong[:, i] ** 2).sum() / ((e[:, i] - e[:, i].mean()) ** 2).sum(), SOLVED)
        same("network r2_pearson", n["r2_pearson"][i], np.corrcoef(network["fitted"][:, i], e[:, i])[0, 1] ** 2, SOLVED)
    check_story(report["story"], session, R, lambda effects: Model(nominal, home, home_l, lead, effects), sigma)
    t = next(t for t in report["tables"] if t["id"] == "model-48-position")
    check_verdict(report["verdict"], t, errors(R["measure-48"].measured, R["measure-48"].target)["position"],
                  left["model", "measure-48"])
    b = report["budget"]
    for row in b["rows"]:
        same(f"budget {row['name']}", row["u_mm"], row["value"] / row["divisor"] * row["sensitivity"])
    own = math.sqrt(math.fsum(row["u_mm"] ** 2 for row in b["rows"]))
    same("budget combined", b["u_mm"], own)
    same("budget U", b["U_k2_mm"], 2 * own)


def check_verdict(text, table, before, after):
    """The headline's figures, and its interval: Student's t of the log ratio of the means."""
    n, a, b = len(before), after.mean(), before.mean()
    s = math.sqrt(((after / a - before / b) ** 2).sum() / (n * (n - 1)))
    low, high = (100 * (math.exp(math.log(a / b) + sign * student(0.05, n - 1) * s) - 1) for sign in (-1, 1))
    own = [f"{b:.4f}", f"{a:.4f}", f"{100 * (a / b - 1):.1f} %", f"{low:.1f} to {high:.1f} %"]
    for words in own:
        if words not in text:
            differences.append(f"the headline lacks {words}: {text}")


def check_identification(found, lsq):
    same("rank", found["rank"], lsq["rank"], 0)
    same("sigma_ratio", found["sigma_ratio"], lsq["ratio"], SOLVED)
    widened = max(1.0, lsq["ratio"])
    alone = np.linalg.norm(lsq["null_in_tolerances"], axis=0) < 0.05
    unit = np.array([math.degrees(1) if row in (ALPHA, BETA) else 1.0 for row, _ in PLACES])

    def same_value(p, of):
        k = NAMES.index(p["name"].split()[0])
        same(f"{p['name']} value", p["value"], unit[k] * (of @ lsq["values"]), SOLVED)
        same(f"{p['name']} u", p["standard_uncertainty"], unit[k] * widened * math.sqrt(of @ lsq["covariance"] @ of), SOLVED)

    for k, p in enumerate(found["parameters"]):
        same(f"{p['name']} identified", p["identified"], bool(alone[k]), 0)
        if alone[k]:
            same_value(p, np.eye(18)[k])
    # A combination of its first parameter with those that lead none, orthogonal to the null space.
    leaders = [NAMES.index(c["name"].split()[0]) for c in found["combinations"]]
    pivots = [k for k in range(18) if not alone[k] and k not in leaders]
    for leader, c in zip(leaders, found["combinations"]):
        of = np.eye(18)[leader]
        of[pivots] = -np.linalg.solve(lsq["null"][:, pivots], lsq["null"][:, leader])
        same_value(c, of)


def check_simulation(tables, nominal, g, home, readings):
    """Sec. 3.5, Figs. 7 and 8."""
    for t, r in zip(tables, readings):
        stands = forward(nominal, r.cmd, home)
        measured, simulated = r.measured - stands, forward(g, r.cmd, home) - stands
        length = [np.hypot(*v[:, :2].T) for v in (measured, simulated, measured - simulated)]
        out = np.hypot(*r.target[:, :2].T)
        rings = [(t, np.ones(len(out), bool))] + [(row, (out > row["from_mm"]) & (out <= row["to_mm"])) for row in t["rings"]]
        for row, pick in rings:
            same("simulation n", row["n"], int(pick.sum()), 0)
            for key, value in zip(("measured_mean_mm", "simulated_mean_mm", "left_mean_mm"), length):
                same(f"simulation {key}", row[key], value[pick].mean(), SOLVED)
        same("simulation left_max_mm", t["left_max_mm"], length[2].max(), SOLVED)


def check_story(story, session, R, model, sigma):
    fitted = []
    for k, round_ in enumerate(story):
        for part in round_["new_fitted"]:
            same("story fitted", part["n"], len(session[part["session"]]), 0)
            fitted += session[part["session"]]
        judged = Readings([row for part in round_["judged_on"] for row in session[part["session"]]])
        r, effects, last = Readings(fitted), [], None
        for step in round_["gap"]:
            if step["model"] == "nominal":
                now = model([])
            else:
                if step["model"] != "geometry":
                    effects.append(step["model"][1:])
                now = model(effects)
                if last is not None:
                    now.z[:len(last.z)] = last.z
                last = now.fit(r, sigma)
            tolerance = EXACT if step["model"] == "nominal" else SOLVED
            same(f"round {k + 1} {step['model']} identify", step["identify_rms_mm"], now.rms(r), tolerance)
            same(f"round {k + 1} {step['model']} validate", step["validate_rms_mm"], now.rms(judged), tolerance)
        names = [e for e in effects for _ in range(6 if e == "screw_periodic" else 3)]
        for e in round_["effects"]:  # averaged over sets of effects: not the named set's own to the last digit
            own = (now.z * now.scale)[21:][[n == e["name"] for n in names]]
            for p, value in zip(e["parameters"], own):
                same(f"round {k + 1} {e['name']} {p['name']}", p["value"], value, AVERAGED * p["std"])


def main():
    folder, report, protocol = sys.argv[1:4]
    np.seterr(over="raise", invalid="raise")
    check(folder, json.load(open(report)), json.load(open(protocol)))
    for line in differences:
        print(line)
    print(f"{compared} figures recomputed, {len(differences)} differ")
    return 1 if differences else 0


if __name__ == "__main__":
    sys.exit(main())
