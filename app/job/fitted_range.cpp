#include "app/job/fitted_range.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/job/stages.hpp"
#include "core/plane/hull.hpp"
#include "core/units.hpp"
#include "store/campaign.hpp"

namespace trammel::job {

namespace {

constexpr double kPhiSlackRad = rad_from_deg(0.05);  // a twentieth of a degree turns nothing new up

}  // namespace

bool FittedRange::holds_place(const Pose& p) const { return inside(hull, {p.x_mm, p.y_mm}); }

bool FittedRange::holds_phi(const Pose& p) const {
  return p.phi_rad >= phi_low_rad - kPhiSlackRad && p.phi_rad <= phi_high_rad + kPhiSlackRad;
}

FittedRange fitted_range(const std::vector<Reading>& fitted) {
  std::vector<Place> places;
  FittedRange range{{}, fitted.front().target.phi_rad, fitted.front().target.phi_rad};
  for (const Reading& r : fitted) {
    places.push_back({r.target.x_mm, r.target.y_mm});
    range.phi_low_rad = std::min(range.phi_low_rad, r.target.phi_rad);
    range.phi_high_rad = std::max(range.phi_high_rad, r.target.phi_rad);
  }
  range.hull = convex_hull(places);
  return range;
}

FittedRange fitted_range(store::Connection& connection, const store::Job& job) {
  return fitted_range(identify_rows(
      store::load_campaign(connection, job.data.campaign_id, {.sessions = job.data.sessions})
          .campaign));
}

std::vector<std::string> extrapolation_words(const FittedRange& range,
                                             std::span<const Pose> targets,
                                             const std::string& points) {
  const auto place =
      std::ranges::count_if(targets, [&range](const Pose& p) { return !range.holds_place(p); });
  const auto phi =
      std::ranges::count_if(targets, [&range](const Pose& p) { return !range.holds_phi(p); });
  std::vector<std::string> words;
  if (place > 0) {
    words.push_back(fmt::format(
        "{} of {} {} lie outside the convex hull of the measured points: there the correction "
        "extrapolates",
        place, targets.size(), points));
  }
  if (phi > 0) {
    words.push_back(fmt::format(
        "{} of {} {} are turned beyond the measured orientations ({:.2f} to {:.2f} deg): there the "
        "correction extrapolates",
        phi, targets.size(), points, deg_from_rad(range.phi_low_rad),
        deg_from_rad(range.phi_high_rad)));
  }
  return words;
}

}  // namespace trammel::job
