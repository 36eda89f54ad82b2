#!/usr/bin/env python3
"""Golden numbers for the ISO 230-2 and ISO 9283 symbols, by the formulas alone (no numpy).

    scripts/make_golden_iso.py     writes tests/core/judge/golden/*.csv; seed 20240607

Written apart from core/assess: straight from the standards' formulas, statistics by Python's own.
"""
import math
import pathlib
import random
import statistics

SEED = 20240607
FOLDER = pathlib.Path(__file__).resolve().parent.parent / "tests/core/judge/golden"
TARGETS, RUNS, VISITS = 11, 5, 30


def iso230(rng):
    rows, up, down = [], [], []
    for i in range(TARGETS):
        error = 0.02 * math.sin(i) + 0.0004 * i * i
        up.append([error + rng.gauss(0, 0.004) for _ in range(RUNS)])
        down.append([error - 0.03 + 0.002 * i + rng.gauss(0, 0.006) for _ in range(RUNS)])
        for j in range(RUNS):
            rows.append((i, j, up[i][j], down[i][j]))
    mu, md = [statistics.mean(x) for x in up], [statistics.mean(x) for x in down]
    su, sd = [statistics.stdev(x) for x in up], [statistics.stdev(x) for x in down]
    back = [a - b for a, b in zip(mu, md)]
    mid = [(a + b) / 2 for a, b in zip(mu, md)]

    def band(means, sigmas, factor):
        return (max(m + factor * s for m, s in zip(means, sigmas))
                - min(m - factor * s for m, s in zip(means, sigmas)))

    figures = {
        "B": max(abs(b) for b in back), "Bm": statistics.mean(back),
        "R_u": max(4 * s for s in su), "R_d": max(4 * s for s in sd),
        "R": max(max(2 * a + 2 * b + abs(c), 4 * a, 4 * b) for a, b, c in zip(su, sd, back)),
        "E_u": band(mu, su, 0), "E_d": band(md, sd, 0), "E": band(mu + md, su + sd, 0),
        "M": max(mid) - min(mid),
        "A_u": band(mu, su, 2), "A_d": band(md, sd, 2), "A": band(mu + md, su + sd, 2),
    }
    return rows, figures


def iso9283(rng):
    rows, means, figures = [], [], {}
    for direction in (1, -1):
        shift = 0.04 * direction
        visits = [(0.05 + shift + rng.gauss(0, 0.01), -0.02 + rng.gauss(0, 0.01),
                   0.001 + rng.gauss(0, 0.0002)) for _ in range(VISITS)]
        rows += [(direction, *v) for v in visits]
        mx, my, mc = (statistics.mean(v[k] for v in visits) for k in range(3))
        length = [math.hypot(v[0] - mx, v[1] - my) for v in visits]
        means.append((mx, my, mc))
        name = "up" if direction > 0 else "down"
        figures[f"AP_p {name}"] = math.hypot(mx, my)
        figures[f"AP_x {name}"], figures[f"AP_y {name}"], figures[f"AP_c {name}"] = mx, my, mc
        figures[f"RP_l {name}"] = statistics.mean(length) + 3 * statistics.stdev(length)
        figures[f"RP_c {name}"] = 3 * statistics.stdev(v[2] for v in visits)
        series = [visits[k:k + 10] for k in range(0, VISITS, 10)]
        ap = [math.hypot(statistics.mean(v[0] for v in s), statistics.mean(v[1] for v in s))
              for s in series]
        figures[f"dAP_p {name}"] = max(abs(a - ap[0]) for a in ap)
    figures["vAP_p"] = math.hypot(means[0][0] - means[1][0], means[0][1] - means[1][1])
    figures["vAP_c"] = abs(means[0][2] - means[1][2])
    return rows, figures


def write(name, header, rows):
    text = [header] + [",".join(repr(v) if isinstance(v, float) else str(v) for v in r)
                       for r in rows]
    (FOLDER / name).write_text("\n".join(text) + "\n")


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    rows, figures = iso230(random.Random(SEED))
    write("iso230_runs.csv", "target,run,up_mm,down_mm", rows)
    write("iso230_figures.csv", "symbol,value", figures.items())
    rows, figures = iso9283(random.Random(SEED + 1))
    write("iso9283_visits.csv", "direction,dx_mm,dy_mm,dphi_rad", rows)
    write("iso9283_figures.csv", "symbol,value", figures.items())


if __name__ == "__main__":
    main()
