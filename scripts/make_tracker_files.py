#!/usr/bin/env python3
"""Writes examples/tracker-files: what two trackers' programs export of a platform with three nests.

The robot is made up: at a target (x, y, phi) it stands at (x + 0.0010 x, y - 0.0005 y, phi + 2e-5 x).
The tracker stands beside it, turned and tilted, and reads each coordinate with 5 um. Seeded: the files
come out the same each time.
"""
import json
import math
import pathlib
import random

SIGMA_MM = 0.005
HEIGHT_MM = 40.0
NESTS = {"P1": (0.0, 86.6025), "P2": (-75.0, -43.3013), "P3": (75.0, -43.3013)}
BASE = {"B1": (-450.0, -300.0, 0.0), "B2": (450.0, -300.0, 0.0), "B3": (0.0, 500.0, 20.0)}


def turn(axis, deg, p):
    a, b = [(1, 2), (2, 0), (0, 1)][axis]
    c, s = math.cos(math.radians(deg)), math.sin(math.radians(deg))
    q = list(p)
    q[a], q[b] = c * p[a] - s * p[b], s * p[a] + c * p[b]
    return q


def seen(rng, p):
    """A point of the base frame as the tracker reads it."""
    q = turn(0, 1.5, turn(2, 25.0, p))
    return [v + o + rng.gauss(0, SIGMA_MM) for v, o in zip(q, (2300.0, -900.0, -450.0))]


def nest_at(nest, target):
    x, y, phi = target
    px, py, a = x + 0.0010 * x, y - 0.0005 * y, phi + 2e-5 * x
    bx, by = NESTS[nest]
    return [px + math.cos(a) * bx - math.sin(a) * by, py + math.sin(a) * bx + math.cos(a) * by, HEIGHT_MM]


def clock(seconds, form):
    h, rest = divmod(9 * 3600 + seconds, 3600)
    m, s = divmod(rest, 60)
    return form.format(h=int(h), m=int(m), s=s)


def spatial_analyzer(poses, folder):
    rng = random.Random(1)
    lines = ["// SpatialAnalyzer SA 2024.2.0923.4 ( x64 )  ",
             "// Points Relative to Coordinate Frame 'A::WORLD'",
             "// AXES = CARTESIAN: X,  Y,  Z (mm)"]
    t = 0

    def add(group, point, xyz):
        nonlocal t
        t += 4
        lines.append("A,  {},  {},  {:.6f},  {:.6f},  {:.6f},  {}".format(
            group, point, *xyz, clock(t, "02/13/25 {h:02}:{m:02}:{s:02}")))

    def base():
        for nest, p in BASE.items():
            add("Base", nest, seen(rng, p))

    base()
    for k, target in enumerate(poses, 1):
        for nest in NESTS:
            xyz = seen(rng, nest_at(nest, target))
            if (k, nest) == (7, "P2"):
                xyz = [0.0, 0.0, 0.0]  # a miss
            if (k, nest) == (16, "P3"):
                xyz[1] += 243.0  # a ghost: a reflection somewhere else
            add("Pose{:02}".format(k), nest, xyz)
        if k % 10 == 0 or k == len(poses):
            base()
    (folder / "spatialanalyzer.txt").write_text("\n".join(lines))  # no newline at the end, as SA does


def leica(poses, folder):
    rng = random.Random(2)
    head = ("X  [mm],Y  [mm],Z  [mm],U(95)  [mm],U(95) X  [mm],U(95) Y  [mm],U(95) Z  [mm],Tilt  [\u00b0],Q0 ,Q1 ,"
            "Q2 ,Q3 ,Image RMS  [\u00b5m],Target,Temperature  [\u00b0C],Pressure  [mBar],Humidity  [%],Time Stamp,"
            "OTG Applied,Delete")
    lines = [head]
    t = 0.12

    def add(xyz, u95, deleted):
        nonlocal t
        t += 3.5
        lines.append("{:.4f},{:.4f},{:.4f},{},{},{},{},0.0,1,0,0,0,1.2,CCR 1.5in,{:.1f},1012.3,45.0,'{},FALSE,{}".format(
            *xyz, u95, u95, u95, u95, 20.0 + t / 1000, clock(t, "13.02.2025 {h:02}:{m:02}:{s:06.3f}"), deleted))

    for k, target in enumerate(poses, 1):
        for repeat in (1, 2):
            for nest in NESTS:
                p = nest_at(nest, target)
                if (k, repeat, nest) == (3, 2, "P1"):
                    add(seen(rng, [p[0] + 0.4, p[1], p[2]]), 0.05, "TRUE")  # touched, and shot again
                add(seen(rng, p), 0 if (k, repeat) == (5, 1) else 0.012, "")
    (folder / "leica.csv").write_bytes(("\r\n".join(lines) + "\r\n").encode("cp1252"))


def main():
    folder = pathlib.Path(__file__).resolve().parent.parent / "examples" / "tracker-files"
    poses = []
    for p in json.loads((folder / "plan.json").read_text())["points"]:
        poses.append((p["x_mm"], p["y_mm"], math.radians(p["phi_deg"])))
    spatial_analyzer(poses, folder)
    leica(poses, folder)


if __name__ == "__main__":
    main()
