// Gross mistakes of a session that has just begun.

#include <algorithm>
#include <array>
#include <cmath>

#include "core/measure/drive_hypotheses.hpp"
#include "core/measure/gross.hpp"
#include "core/measure/lie.hpp"
#include "core/measure/printed.hpp"

namespace trammel {

using namespace poses;

std::vector<Suspicion> gross_mistakes_of_few(const Campaign& as_measured) {
  const Campaign campaign = completed(as_measured);
  struct Undo {
    Mistake kind;
    const char* what;
    Pose (*pose)(const Pose& measured, const Pose& target);
  };
  constexpr std::array<Undo, 9> kUndo = {{
      {Mistake::scale, "measured x and y are metres",
       [](const Pose& p, const Pose&) {
         return Pose{1e3 * p.x_mm, 1e3 * p.y_mm, p.phi_rad};
       }},
      {Mistake::scale, "measured x and y are inches",
       [](const Pose& p, const Pose&) {
         return Pose{25.4 * p.x_mm, 25.4 * p.y_mm, p.phi_rad};
       }},
      {Mistake::frame_mirrored, "x has the wrong sign",
       [](const Pose& p, const Pose&) {
         return Pose{-p.x_mm, p.y_mm, p.phi_rad};
       }},
      {Mistake::frame_mirrored, "y has the wrong sign",
       [](const Pose& p, const Pose&) {
         return Pose{p.x_mm, -p.y_mm, p.phi_rad};
       }},
      {Mistake::frame_mirrored, "x and y have changed places",
       [](const Pose& p, const Pose&) {
         return Pose{p.y_mm, p.x_mm, p.phi_rad};
       }},
      {Mistake::frame_turned, "the frame is turned by 90 deg",
       [](const Pose& p, const Pose&) {
         return Pose{p.y_mm, -p.x_mm, p.phi_rad};
       }},
      {Mistake::frame_turned, "the frame is turned by -90 deg",
       [](const Pose& p, const Pose&) {
         return Pose{-p.y_mm, p.x_mm, p.phi_rad};
       }},
      {Mistake::frame_turned, "the frame is turned by 180 deg",
       [](const Pose& p, const Pose&) {
         return Pose{-p.x_mm, -p.y_mm, p.phi_rad};
       }},
      {Mistake::deviations, "deviations from the targets stand in place of measured poses",
       [](const Pose& p, const Pose& t) {
         return Pose{p.x_mm + t.x_mm, p.y_mm + t.y_mm, 0};
       }},
  }};
  constexpr double kTenth = 0.1;  // of few readings a fifth is chance
  std::vector<FittedMistake> fitted;
  const auto consider = [&](Mistake kind, std::string what, double left_mm, double now_mm) {
    if (!(left_mm < kCloseMm && left_mm < kTenth * now_mm)) return;
    fitted.push_back({{kind, std::move(what),
                       printed("within %.2g mm so, within %.3g mm as they are", left_mm, now_mm)},
                      std::max(left_mm, kNothingMm)});
  };
  const auto farthest = [&](const auto& off_of) {
    double most = 0;
    for (const Reading& r : campaign.readings) {
      if (r.measured) most = std::max(most, off_of(r));
    }
    return most;
  };
  const auto apart = [](const Pose& p, const Pose& t) {
    return std::abs(place_of(p) - place_of(t));
  };
  const double now_mm = farthest([&](const Reading& r) { return apart(*r.measured, r.target); });
  for (const Undo& undo : kUndo) {
    consider(undo.kind, undo.what, farthest([&](const Reading& r) {
               return apart(undo.pose(*r.measured, r.target), r.target);
             }),
             now_mm);
  }
  const MachineSolver solver(campaign.machine);
  const InverseResult home = solver.drives(solver.machine().home);
  if (!home.ok()) return {};
  const auto in_drives = [&](const DriveModel& model) {
    return farthest([&](const Reading& r) {
      const Displaced l = displacements_at(model, *r.measured);
      const Displaced at_home = displacements_at(model, solver.machine().home);
      if (!l || !at_home) return static_cast<double>(INFINITY);
      // From home on: what a drive counts there is not known.
      const Displacements way = *l - *at_home - (r.conditions.cmd_mm - home.l_mm);
      return way.cwiseAbs().maxCoeff();
    });
  };
  const double drives_now_mm = in_drives({solver});
  for (const DriveHypothesis& h : hypotheses_of_drives(solver)) {
    if (h.kind != Mistake::working_mode)
      consider(h.kind, h.what, in_drives(h.model), drives_now_mm);
  }
  std::stable_sort(
      fitted.begin(), fitted.end(),
      [](const FittedMistake& a, const FittedMistake& b) { return a.left_mm < b.left_mm; });
  std::vector<Suspicion> found;
  for (const FittedMistake& f : fitted) {
    if (found.size() < 2 && (found.empty() || found.front().kind != f.suspicion.kind))
      found.push_back(f.suspicion);
  }
  return found;
}

}  // namespace trammel
