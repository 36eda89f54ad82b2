#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "app/job/text.hpp"
#include "app/report/assess/assessment.hpp"
#include "app/report/budget.hpp"
#include "app/report/print.hpp"
#include "app/terminal/counted.hpp"
#include "app/terminal/decimals.hpp"
#include "app/terminal/text.hpp"
#include "core/calibrate/uncertainty.hpp"
#include "core/units.hpp"

namespace trammel::assess {

namespace {

/// Given symbols a line each, refused ones gathered by their reason.
std::string symbols_text(const std::vector<IsoSymbol>& symbols) {
  std::string text;
  std::vector<std::pair<std::string, std::string>> refused;  // reason, names
  for (const IsoSymbol& s : symbols) {
    if (!s.value) {
      const auto at = std::ranges::find_if(refused, [&](auto& r) { return r.first == s.reason; });
      if (at == refused.end()) {
        refused.emplace_back(s.reason, s.name);
      } else {
        at->second += ", " + s.name;
      }
      continue;
    }
    const double unit = s.is_angle ? deg_from_rad(1) : 1;
    const int decimals = terminal::decimals_of(unit * s.floor.value_or(0));
    text += fmt::format("    {:<18}{:>9.{}f} {:<4}", s.name, unit * *s.value, decimals,
                        s.is_angle ? "deg" : "mm");
    if (s.floor) text += fmt::format("  a perfect robot reads {:.{}f}", unit * *s.floor, decimals);
    if (!s.reason.empty()) text += (s.floor ? "; " : "  ") + s.reason;
    text += "\n";
  }
  for (const auto& [reason, names] : refused) {
    text += fmt::format("    refused: {}: {}\n", names, reason);
  }
  return text;
}

/// Of a circle that holds 95 % of a plane normal scatter, in its sigma: sqrt(-2 ln 0.05).
constexpr double k95Radius = 2.4477;

std::string visits(int least, int most) {
  return (least == most ? fmt::format("n = {}", most) : fmt::format("n = {} to {}", least, most)) +
         (most == 1 ? " visit" : " visits");
}

/// Target by target where the standard's figures are refused: they need none of its conditions.
std::string reversals_text(const Iso230& rail) {
  const bool all =
      std::ranges::all_of(rail.symbols, [](const IsoSymbol& s) { return s.value.has_value(); });
  std::string text;
  for (const Reversal& r : rail.reversals) {
    if (all || !r.fit) continue;
    text += fmt::format(
        "    at {:.3f} mm: B_i {:+.2f} +- {:.2f} um, drift {:+.2f} +- {:.2f} um a run, s_i {:.2f} "
        "up {:.2f} down ({} and {} runs)\n",
        r.position_mm, 1e3 * r.fit->B_mm, 1e3 * r.fit->B_error_mm, 1e3 * r.fit->drift_mm,
        1e3 * r.fit->drift_error_mm, 1e3 * *r.s_up_mm, 1e3 * *r.s_down_mm, r.n_up, r.n_down);
  }
  return text;
}

std::string session_text(const Session& s, int decimals) {
  std::string text =
      fmt::format("\nsession {}: {}, {}\n", terminal::printable(s.name),
                  terminal::counted(s.position_mm.n, "reading"),
                  s.compensation_job ? fmt::format("compensated by job {}", *s.compensation_job)
                  : s.compensation.empty() ? "baseline"
                                           : "compensated by " + s.compensation);
  text += fmt::format(
      "  mean positional deviation {0:.{5}f} mm, {1} a pose (95 %: {2:.{5}f}, max "
      "{3:.{5}f}){4}\n",
      s.position_mm.mean, visits(s.poses.least_n, s.poses.most_n), s.position_mm.p95,
      s.position_mm.max,
      s.attitude_rad.n == 0
          ? ""
          : fmt::format("; attitude {:.4f} deg", deg_from_rad(s.attitude_rad.mean)),
      decimals);
  if (!s.verdict.empty()) text += "  " + s.verdict + "\n";
  text += fmt::format("  ISO 9283, {} (with direction and set-up), largest of all:\n",
                      terminal::counted(s.poses.n_poses, "pose"));
  text += symbols_text(s.poses.symbols);
  for (const Iso230& rail : s.rails) {
    text += rail.rail == 0 ? "  ISO 230-2:\n"
                           : fmt::format("  ISO 230-2, {} {}: {} over {:.1f} mm, {}:\n", s.drive,
                                         rail.rail, terminal::counted(rail.n_targets, "target"),
                                         rail.travel_mm, terminal::counted(rail.least_runs, "run"));
    text += symbols_text(rail.symbols);
    text += reversals_text(rail);
  }
  return text;
}

/// U over the points that have one, and why the others have none.
std::string uncertainty_text(const Judged& j, int decimals) {
  std::vector<double> U, U_rad;
  std::map<std::string, std::size_t> without;
  for (const Point& p : j.points) {
    if (p.U) {
      U.push_back(p.U->U_mm);
      U_rad.push_back(p.U->U_rad);
    } else {
      ++without[p.why_no_U];
    }
  }
  std::string text;
  if (!U.empty()) {
    const Summary u = summarise(U), phi = summarise(U_rad);
    text = fmt::format(
        "    U (k = 2) of a coordinate {0:.{6}f} to {1:.{6}f} mm, mean {2:.{6}f}; of the position "
        "(radius, 95 %) {3:.{6}f} mm on average{4}; {5}\n",
        u.min, u.max, u.mean, k95Radius * u.mean / 2,
        phi.max == 0 ? ""  // it does not turn
                     : fmt::format("; of phi {:.4f} to {:.4f} deg", deg_from_rad(phi.min),
                                   deg_from_rad(phi.max)),
        report::points_in_words(U.size()), decimals);
  }
  for (const auto& [why, n] : without)
    text += fmt::format("    no U at {}: {}\n", report::points_in_words(n), why);
  return text;
}

std::string judged_text(const Judged& j, int decimals) {
  std::string text = fmt::format(
      "  {0} ({1}), {2}, after {3}: mean {4:.{11}f} -> {5:.{11}f} mm, 95 % {6:.{11}f} -> "
      "{7:.{11}f}, max {8:.{11}f} -> {9:.{11}f}, n = {10}\n",
      terminal::printable(j.session), j.set,
      j.cross_validated ? "held-out by cross-validation" : name_of(j.standing),
      j.predicted ? "predicted" : "measured", j.before_mm.mean, j.after_mm.mean, j.before_mm.p95,
      j.after_mm.p95, j.before_mm.max, j.after_mm.max, j.after_mm.n, decimals);
  if (j.standing == Standing::unknown_epoch) return text;
  if (j.improvement_pct) text += fmt::format("    improvement {:.1f} %", *j.improvement_pct);
  if (j.improvement_95_pct) {
    text += fmt::format(", 95 % interval {:.1f} to {:.1f} % (t of the log ratio)",
                        j.improvement_95_pct->low, j.improvement_95_pct->high);
  } else {
    text += std::string(j.improvement_pct ? ", " : "    ") + "too few points for an interval";
  }
  text += "\n" + uncertainty_text(j, decimals);
  if (j.covered_pct) {
    text += fmt::format(
        "    {:.1f} % of the coordinates lie within U and the reading's noise (95 % expected{})\n",
        *j.covered_pct,
        j.n_covered >= kFewestHeldOut ? ", by construction: these errors set the factor of U" : "");
  }
  if (!j.verdict.empty()) text += "    " + j.verdict + "\n";
  return text;
}

}  // namespace

std::string to_text(const Assessment& a) {
  std::string text =
      fmt::format("campaign {}\n{}\n",
                  job::campaign_title(terminal::printable(a.campaign), a.simulated), a.noise);
  const int decimals = terminal::decimals_of(a.floor_mean_mm.value_or(0));
  if (a.floor_mean_mm) {
    text +=
        fmt::format("mean length of a perfect reading: {:.{}f} mm\n", *a.floor_mean_mm, decimals);
  }
  for (const Session& s : a.sessions) text += session_text(s, decimals);
  if (a.job) {
    text += fmt::format("\njob {}: {}\n", a.job->id, a.job->stage);
    if (!a.job->uncertainty_from.empty()) text += "  U from " + a.job->uncertainty_from + "\n";
    text += report::budget_text(a.job->budget);
    for (const Judged& j : a.job->sets) text += judged_text(j, decimals);
    for (const std::string& w : a.job->warnings) text += "  warning: " + w + "\n";
  }
  return text +
         "\nISO symbols: to be checked against the standards before anyone certifies by them.\n";
}

}  // namespace trammel::assess
