"""What a user of numpy, scipy and sklearn would write for the same work, as fast as we know how.

Each peer takes the inputs that trammel_bench reads too and returns its values, so that both can be compared.
"""
import hashlib
import json
import sqlite3

import numpy as np
from scipy.optimize import least_squares
from scipy.special import chdtri
from sklearn.cluster import KMeans

SIGMA = np.array([0.010, 0.010, np.radians(0.004)])  # mm, mm, rad
ALPHA, BETA = np.radians([270, 30, 150]), np.radians([30, 150, 270])
R_RAIL, S_LINK, R_PLATFORM = 733.0, 430.0, 100.0
NOMINAL = np.array([[a, b, R_PLATFORM, S_LINK, 0.0, R_RAIL, 0.0] for a, b in zip(ALPHA, BETA)])
COLUMNS = [0, 1, 2, 3, 4, 6]  # of a chain: alpha beta r S l h; R acts as l does


def wrap(phi):
    return (phi + np.pi) % (2 * np.pi) - np.pi


def chain_vectors(chains, l, X):
    """B_i C_i [n, 3, 2] of n poses, and u, n of each rail, cos and sin of beta + phi."""
    alpha, beta, r, _, zero, R, h = chains.T
    u = np.stack([np.cos(alpha), np.sin(alpha)], -1)
    normal = np.stack([-u[:, 1], u[:, 0]], -1)
    gamma = beta + X[:, 2:]
    turn = np.stack([np.cos(gamma), np.sin(gamma)], -1)
    B = (l + zero - R)[..., None] * u + h[:, None] * normal
    return X[:, None, :2] + r[:, None] * turn - B, u, normal, turn


def pose_rows(chains, v, turn):
    """d(|v|^2 / 2) / d(x, y, phi) [n, 3, 3]."""
    cross = v[..., 1] * turn[..., 0] - v[..., 0] * turn[..., 1]
    return np.concatenate([v, (chains[:, 2] * cross)[..., None]], -1)


def forward(chains, l, X):
    """Poses [n, 3] of displacements l [n, 3] by Newton's method from X, all n side by side."""
    for _ in range(20):
        v, _, _, turn = chain_vectors(chains, l, X)
        gap = 0.5 * (np.einsum("nij,nij->ni", v, v) - chains[:, 3] ** 2)
        step = np.linalg.solve(pose_rows(chains, v, turn), gap[..., None])[..., 0]
        X = X - step
        if np.abs(step).max() < 1e-11:
            return X
    raise ArithmeticError("no pose found")


def pose_jacobian(chains, l, X):
    """d(x, y, phi) / d(alpha beta r S l R h of each chain) [n, 3, 21]."""
    v, u, normal, turn = chain_vectors(chains, l, X)
    _, _, r, S, zero, R, h = chains.T
    along, across = np.einsum("nij,ij->ni", v, u), np.einsum("nij,ij->ni", v, normal)
    cross = v[..., 1] * turn[..., 0] - v[..., 0] * turn[..., 1]
    alpha = -((l + zero - R) * across - h * along)
    own = np.stack([alpha, r * cross, np.einsum("nij,nij->ni", v, turn), np.broadcast_to(-S, alpha.shape),
                    -along, along, -across], -1)
    rows = np.zeros(alpha.shape + (21,))
    for i in range(3):
        rows[:, i, 7 * i:7 * i + 7] = own[:, i]
    return -np.linalg.solve(pose_rows(chains, v, turn), rows)


class Identification:
    """Residuals of 18 parameters in tolerances (0.05 deg, 0.1 mm), whitened."""

    def __init__(self, readings):
        self.l, self.measured = readings[:, :3], readings[:, 3:]
        self.scale = np.tile([np.radians(0.05), np.radians(0.05), 0.1, 0.1, 0.1, 0.1], 3)

    def chains(self, z):
        chains = NOMINAL.copy()
        chains[:, COLUMNS] += (z * self.scale).reshape(3, 6)
        return chains

    def residual(self, z):
        X = forward(self.chains(z), self.l, self.measured)
        return ((X - self.measured) / SIGMA).ravel()

    def jacobian(self, z):
        chains = self.chains(z)
        X = forward(chains, self.l, self.measured)
        J = pose_jacobian(chains, self.l, X)[:, :, [7 * i + k for i in range(3) for k in COLUMNS]]
        return (J * self.scale / SIGMA[:, None]).reshape(-1, 18)

    def default(self):
        return 2 * least_squares(self.residual, np.zeros(18)).cost

    def lm(self):
        return 2 * least_squares(self.residual, np.zeros(18), jac=self.jacobian, method="lm").cost


def idw(samples, queries, chunk=1024):
    """Chunks, d^2 = |q|^2 + |s|^2 - 2 q.s by BLAS, sums by BLAS, nothing allocated twice."""
    at, values = samples[:, :2], np.hstack([samples[:, 2:], np.ones((len(samples), 1))])
    s2, minus_2_s = (at * at).sum(1), np.ascontiguousarray(-2 * at.T)
    out, block = np.empty((len(queries), 3)), np.empty((chunk, len(samples)))
    for k in range(0, len(queries), chunk):
        q = queries[k:k + chunk]
        d2 = np.matmul(q, minus_2_s, out=block[:len(q)])
        d2 += s2
        d2 += (q * q).sum(1)[:, None]
        sums = np.reciprocal(d2, out=d2) @ values
        out[k:k + chunk] = sums[:, :3] / sums[:, 3:]
    return out


def augmented(queries):
    """(x, y, 1, x^2 + y^2): with (-2 s, |s|^2, 1) one product gives d^2. The quickest form we found."""
    return np.hstack([queries, np.ones((len(queries), 1)), (queries * queries).sum(1)[:, None]])


def idw_augmented(samples, queries, chunk=1024):
    at, values = samples[:, :2], np.hstack([samples[:, 2:], np.ones((len(samples), 1))])
    centres = np.vstack([-2 * at.T, (at * at).sum(1), np.ones(len(at))])
    out, block = np.empty((len(queries), 3)), np.empty((chunk, len(samples)))
    for k in range(0, len(queries), chunk):
        q = augmented(queries[k:k + chunk])
        w = np.matmul(q, centres, out=block[:len(q)])
        sums = np.reciprocal(w, out=w) @ values
        out[k:k + chunk] = sums[:, :3] / sums[:, 3:]
    return out


def rbf(network, queries, chunk=1024):
    rows, sigma, bias = network[:250].reshape(50, 5), network[250], network[251:]
    at, k2 = rows[:, :2], -1 / sigma ** 2
    centres = k2 * np.vstack([-2 * at.T, (at * at).sum(1), np.ones(50)])
    weights = np.ascontiguousarray(rows[:, 2:])
    out, block = np.empty((len(queries), 3)), np.empty((chunk, 50))
    for k in range(0, len(queries), chunk):
        q = augmented(queries[k:k + chunk])
        g = np.matmul(q, centres, out=block[:len(q)])
        np.matmul(np.exp(g, out=g), weights, out=out[k:k + chunk])
    out += bias
    return out


def rbf_exact(network, queries):
    """Without the cancellation of |q|^2 + |s|^2 - 2 q.s, for the comparison of values."""
    rows, sigma, bias = network[:250].reshape(50, 5), network[250], network[251:]
    d2 = (queries[:, :1] - rows[:, 0]) ** 2 + (queries[:, 1:] - rows[:, 1]) ** 2
    return np.exp(-d2 / sigma ** 2) @ rows[:, 2:] + bias


def train(samples, sigma=60.0):
    """Centres by one start of k-means, as ours; weights and bias by lstsq."""
    at = samples[:, :2]
    centres = KMeans(50, n_init=1, random_state=1).fit(at).cluster_centers_
    phi = lambda q: np.hstack([np.exp(-((q[:, None] - centres) ** 2).sum(-1) / sigma ** 2), np.ones((len(q), 1))])
    weights = np.linalg.lstsq(phi(at), samples[:, 2:], rcond=None)[0]
    return lambda q: phi(q) @ weights


CA, SA, TURN = np.cos(ALPHA), np.sin(ALPHA), BETA - ALPHA
K1, K2 = R_PLATFORM * np.cos(TURN), R_PLATFORM * np.sin(TURN)


def inverse(poses, chunk=4096):
    """Displacements [n, 3], chain by chain in its rail's frame, in chunks that stay in the cache."""
    out = np.empty((len(poses), 3))
    for k in range(0, len(poses), chunk):
        x, y, phi = np.ascontiguousarray(poses[k:k + chunk].T)
        c, s = np.cos(phi), np.sin(phi)
        for i in range(3):
            across = y * CA[i] - x * SA[i] + (K2[i] * c + K1[i] * s)
            across *= across
            np.subtract(S_LINK ** 2, across, out=across)
            np.sqrt(across, out=across)
            out[k:k + chunk, i] = x * CA[i] + y * SA[i] + (K1[i] * c - K2[i] * s) + R_RAIL - across
    return out


def inverse_one(pose):
    """One pose, the three chains side by side."""
    x, y, phi = pose
    c, s = np.cos(phi), np.sin(phi)
    across = y * CA - x * SA + (K2 * c + K1 * s)
    return x * CA + y * SA + (K1 * c - K2 * s) + R_RAIL - np.sqrt(S_LINK ** 2 - across * across)




def lsq(mechanism, tracker, cmd, measured, tolerance, steps=10, least_signal=0.05):
    """The paper's 18 parameters by repeated linear least squares of least change: chains [3, 7], the changes in
    tolerances, the singular values and directions at the start, the rank, and the whitened residuals [n, 3]."""
    chains, columns = mechanism.copy(), [7 * i + k for i in range(3) for k in range(6)]
    previous, total = 0, np.zeros(18)
    directions = None  # that the readings tell at the start: later steps stay in them
    for _ in range(steps):
        X = forward(chains, cmd, measured)
        b = measured - X
        b[:, 2] = wrap(b[:, 2])
        A = (pose_jacobian(chains, cmd, X)[:, :, columns] * tolerance / tracker[:, None]).reshape(-1, 18)
        if directions is None:
            _, s, Vt = np.linalg.svd(A, full_matrices=False)
            rank = (s > least_signal).sum()
            directions = Vt[:rank].T
        left = (b / tracker).ravel()
        z = directions @ np.linalg.lstsq(A @ directions, left, rcond=None)[0]
        total += z
        chains[:, :6] += (z * tolerance).reshape(3, 6)
        size = np.abs(z).max()
        if (size * min(1, size / previous) if previous else size) < 1e-6:  # the next step, as the last ones shrink
            break
        previous = size
    return chains, total, s, Vt, rank, (left - A @ z).reshape(-1, 3)


NAMES = [f"{name}_{i}" for i in (1, 2, 3) for name in ("alpha", "beta", "r", "S", "l", "R")]
SHOWN = np.tile([180 / np.pi, 180 / np.pi, 1, 1, 1, 1], 3)  # deg and mm
GIVEN_UP_FIRST = [6 * i + k for k in (5, 3, 2, 1, 0, 4) for i in range(3)]  # where a tie leaves the choice


def ties(null):
    """The directions that no reading feels [m, 18], each by the parameter that it gives up, and those parameters."""
    rows, pivots = null.copy(), []
    for column in GIVEN_UP_FIRST:
        row = len(pivots)
        if row == len(rows):
            break
        at = row + np.abs(rows[row:, column]).argmax()
        if abs(rows[at, column]) < 0.05:
            continue
        rows[[row, at]] = rows[[at, row]]
        rows[row] /= rows[row, column]
        others = rows[:, column].copy()
        others[row] = 0
        rows -= others[:, None] * rows[row]
        pivots.append(column)
    return rows, pivots


def known(total, s, Vt, rank, left, tolerance):
    """What a job holds of an identification: each parameter and each combination that the readings tell, their
    uncertainties and strong correlations, what no reading feels, observability, and whether noise explains the rest."""
    n = left.size
    squares = (left * left).sum(0)
    chi2, dof = squares.sum(), n - rank
    ratio, limit = np.sqrt(chi2 / dof), np.sqrt(chdtri(dof, 1e-3) / dof)
    half = (Vt[:rank].T / s[:rank]) * (tolerance * max(1, ratio))[:, None]
    covariance = half @ half.T
    alone = np.sqrt((Vt[rank:] ** 2).sum(0)) < 0.05
    null, pivots = ties(Vt[rank:])
    combined = np.eye(18)
    combined[:, pivots] -= (null * tolerance).T / tolerance[pivots]
    free = np.setdiff1d(np.arange(18), pivots)
    combined = combined[free]
    values = total * tolerance
    change, with_all = combined @ values, combined @ covariance @ combined.T
    spread = np.sqrt(with_all.diagonal())
    r = with_all / np.outer(spread, spread)
    strong = [(NAMES[free[i]], NAMES[free[j]], r[i, j]) for i, j in zip(*np.nonzero(np.triu(np.abs(r) > 0.9, 1)))]
    kept = s[:rank]
    return {"parameters": [NAMES, alone.tolist(), (values * SHOWN).tolist(),
                           (np.sqrt(covariance.diagonal()) * SHOWN).tolist()],
            "identified": [[NAMES[k] for k in free], (change * SHOWN[free]).tolist(), (spread * SHOWN[free]).tolist()],
            "not_identified": [[NAMES[k] for k in pivots], null.tolist()], "correlations": strong,
            "observability": [np.exp(np.log(kept).mean()) / np.sqrt(n / 3), kept[-1] / kept[0], kept[-1],
                              kept[-1] ** 2 / kept[0], 1 / (1 / kept).sum()],
            "chi2": chi2, "ratio": ratio, "limit": limit, "explained": bool(ratio <= limit),
            "rms": [np.sqrt((squares[0] + squares[1]) / (2 * n / 3)), np.sqrt(squares[2] / (n / 3))]}


def rows_of(db, sql, *values):
    return np.array(db.execute(sql, values).fetchall())


def interval(before, after, picks):
    """95 % of the gain of the mean, paired bootstrap: the resamples are those of every campaign."""
    return np.percentile(100 * (1 - after[picks].sum(1) / before[picks].sum(1)), [2.5, 97.5])


def figures(error):
    """What a job keeps of the errors [n, 3]: mean, max, min and 95th percentile of position and of attitude."""
    values = np.vstack([np.hypot(error[:, 0], error[:, 1]), np.abs(np.degrees(error[:, 2]))])
    return np.vstack([values.mean(1), values.max(1), values.min(1), np.percentile(values, 95, axis=1)]).ravel().tolist()


def recalibrate(file, n_campaigns, whole=True):
    """Loads, identifies and stores campaign by campaign; a commit every 64. `whole`: what a job of ours holds, but for
    its sentences: what is known, figures, simulation, interval, a key of what went in and a seal of what came out."""
    db = sqlite3.connect(file, isolation_level=None)
    db.executescript("""PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL;
        CREATE TABLE loop_job (campaign_id INTEGER PRIMARY KEY, chains TEXT, mean_before REAL, mean_after REAL,
                               result TEXT, key TEXT, seal TEXT);
        CREATE TABLE loop_point (campaign_id INTEGER, seq INTEGER, bx REAL, by REAL, bphi REAL, ax REAL, ay REAL,
                                 aphi REAL, PRIMARY KEY (campaign_id, seq))""")
    tolerance = np.radians([0.05, 0.05, 0, 0, 0, 0]) + [0, 0, 0.1, 0.1, 0.1, 0.1]
    picks = np.random.default_rng(1).integers(0, 80, (2000, 80))
    length = lambda error: np.hypot(error[:, 0], error[:, 1])
    db.execute("BEGIN")
    for k, (campaign, sigma_xy, sigma_phi) in enumerate(db.execute(
            "SELECT campaign_id, tracker_sigma_xy_mm, tracker_sigma_phi_rad FROM campaign ORDER BY campaign_id "
            "LIMIT ?", (n_campaigns,)).fetchall()):
        mechanism = rows_of(db, "SELECT alpha_rad, beta_rad, platform_r_mm, link_S_mm, l_zero_mm, rail_R_mm, h_mm "
                            "FROM campaign_chain WHERE campaign_id = ? ORDER BY chain", campaign)
        data = rows_of(db, "SELECT seq, target_x_mm, target_y_mm, target_phi_rad, cmd_l1_mm, cmd_l2_mm, cmd_l3_mm, "
                       "x_mm, y_mm, phi_rad FROM reading WHERE campaign_id = ? AND reading_set = 'identify' "
                       "ORDER BY seq", campaign)
        target, cmd, measured = data[:, 1:4], data[:, 4:7], data[:, 7:]
        scale = np.tile(tolerance, 3)
        chains, *found = lsq(mechanism, np.array([sigma_xy, sigma_xy, sigma_phi]), cmd, measured, scale)
        before, after = measured - target, measured - forward(chains, cmd, measured)
        result = key = seal = None
        if whole:
            key = hashlib.sha256(mechanism.tobytes() + data.tobytes()).hexdigest()
            nominal = forward(mechanism, cmd, target)
            shown, seen = measured - after - nominal, measured - nominal
            result = json.dumps({"known": known(*found, scale), "before": figures(before), "after": figures(after),
                                 "simulated": [length(e).mean() for e in (seen, shown, seen - shown)],
                                 "interval": interval(length(before), length(after), picks).tolist()})
            seal = hashlib.sha256(f"{campaign}{key}{result}".encode()).hexdigest()
        db.execute("INSERT INTO loop_job VALUES (?, ?, ?, ?, ?, ?, ?)",
                   (campaign, json.dumps(chains.tolist()), length(before).mean(), length(after).mean(), result, key,
                    seal))
        points = np.hstack([data[:, :1], before, after]).tolist()
        db.executemany("INSERT INTO loop_point VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
                       [(campaign, int(p[0]), *p[1:]) for p in points])
        if k % 64 == 63:
            db.execute("COMMIT")
            db.execute("BEGIN")
    db.execute("COMMIT")
    db.close()


def looped_geometry(file):
    db = sqlite3.connect(file)
    return [np.array(json.loads(text)) for text, in db.execute("SELECT chains FROM loop_job ORDER BY campaign_id")]


def stored_geometry(file, n_campaigns):
    """What the jobs of the same campaigns hold."""
    names = ("alpha_rad", "beta_rad", "r_mm", "S_mm", "l_zero_mm", "R_mm", "h_mm")
    texts = sqlite3.connect(file).execute("SELECT result_json FROM job ORDER BY campaign_id LIMIT ?", (n_campaigns,))
    return [np.array([[chain[name] for name in names] for chain in json.loads(text)["correction"]["chains"]])
            for text, in texts]
