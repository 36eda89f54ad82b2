#include "app/report/remarks.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/terminal/counted.hpp"
#include "core/statistics/interval.hpp"
#include "store/session.hpp"

namespace trammel::report {

namespace {

/// By more than the points' own scatter can make of nothing; not for fewer than five of them.
bool is_worse(const ErrorTable& table) {
  std::vector<double> before, after;
  for (const PointError& p : table.points) {
    before.push_back(p.before);
    after.push_back(p.after);
  }
  const auto larger = paired_difference(after, before);
  return larger && larger->low > 0;
}

}  // namespace

std::vector<std::string> remarks_on(const Report& report) {
  struct Worse {
    std::string method, figure, text;
  };
  std::vector<Worse> found;
  for (const ErrorTable& t : report.tables) {
    if (t.standing == Standing::unknown_epoch || !is_worse(t)) continue;
    const std::string figures =
        fmt::format("mean {:.{}f} -> {:.{}f} {} on {} {} points, {}", t.before.mean, t.decimals,
                    t.after.mean, t.decimals, t.unit, t.before.n, name_of(t.standing),
                    t.after_predicted ? "predicted" : "measured again");
    const auto same = std::find_if(found.begin(), found.end(), [&](const Worse& w) {
      return w.method == t.method && w.figure == t.figure;
    });
    if (same != found.end()) {
      same->text += "; " + figures;
    } else {
      found.push_back(
          {t.method, t.figure, fmt::format("{} makes {} worse: {}", t.method, t.figure, figures)});
    }
  }
  std::vector<std::string> remarks;
  for (const Worse& w : found) {
    std::string text = w.text + ".";
    const bool explained = w.method == "lsq" && w.figure == "attitude" && report.identification &&
                           !report.identification->explained;
    if (explained && !report.identification->why_attitude.empty()) {
      text += " " + report.identification->why_attitude;
    }
    remarks.push_back(text);
  }
  for (const SessionRow& s : report.sessions) {
    if (s.n_done == 0 || s.n_done >= s.n_points || s.plan == store::kReferencePlan) continue;
    remarks.push_back(
        fmt::format("session {} has measured {} of {}: {}.", s.name, s.n_done,
                    terminal::counted(s.n_points, "point"),
                    s.counts ? "its figures are of these alone"
                             : "no figure is made of it, the last complete session stands"));
  }
  return remarks;
}

}  // namespace trammel::report
