#!/usr/bin/env python3
"""Where the robot stood, from a laboratory's database: point_errors.py LABORATORY.db SESSION [MAP.png]"""
import sqlite3
import sys

if len(sys.argv) < 3:
    sys.exit(__doc__)
file, session = sys.argv[1:3]
try:
    laboratory = sqlite3.connect(f"file:{file}?mode=ro", uri=True)  # read only: the laboratory stays as it is
    sessions = [name for (name,) in laboratory.execute("SELECT DISTINCT session FROM v_point_error")]
except sqlite3.Error as error:
    sys.exit(f"{file}: {error}")
if session not in sessions:
    sys.exit(f"{file}: no session {session} with readings; there are: {', '.join(sessions)}")
rows = laboratory.execute(
    "SELECT target_x_mm, target_y_mm, error_x_mm, error_y_mm, position_mm FROM v_point_error"
    " WHERE session = ? AND excluded IS NULL ORDER BY seq", (session,)).fetchall()
x, y, ex, ey, position = zip(*rows)  # with pandas: pandas.read_sql_query(the same, laboratory, params=(session,))
print(f"{session}: {len(rows)} readings, mean {sum(position) / len(rows):.4f} mm, max {max(position):.4f} mm")
for row in sorted(set(y), reverse=True):  # a map in text: an eighth of the largest error a step
    at = {xk: pk for xk, yk, pk in zip(x, y, position) if yk == row}
    print(f"{row:8.1f} ", "".join(" 12345678"[round(8 * at[xk] / max(position))] if xk in at else "." for xk in sorted(set(x))))
if len(sys.argv) > 3:  # a map of arrows, where matplotlib is there
    from matplotlib import pyplot

    pyplot.quiver(x, y, ex, ey, position, angles="xy")
    pyplot.colorbar(label="position error, mm")
    pyplot.savefig(sys.argv[3])
