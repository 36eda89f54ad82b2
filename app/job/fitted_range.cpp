#include "app/job/fitted_range.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/job/stages.hpp"
#include "app/terminal/counted.hpp"
#include "core/units.hpp"
#include "store/campaign.hpp"

namespace trammel::job {

FittedRange fitted_range(store::Connection& connection, const store::Job& job) {
  return trammel::fitted_range(identify_rows(
      store::load_campaign(connection, job.data.campaign_id, {.sessions = job.data.sessions})
          .campaign));
}

std::vector<std::string> extrapolation_words(const FittedRange& range,
                                             std::span<const Pose> targets,
                                             const std::string& point, const std::string& of) {
  const auto place =
      std::ranges::count_if(targets, [&range](const Pose& p) { return !range.holds_place(p); });
  const auto phi =
      std::ranges::count_if(targets, [&range](const Pose& p) { return !range.holds_phi(p); });
  const std::string all = terminal::counted(targets.size(), point) + of;
  std::vector<std::string> words;
  if (place > 0) {
    words.push_back(fmt::format(
        "{} of {} {} outside the convex hull of the measured points: there the correction "
        "extrapolates",
        place, all, place == 1 ? "lies" : "lie"));
  }
  if (phi > 0) {
    words.push_back(fmt::format(
        "{} of {} {} turned beyond the measured orientations ({:.2f} to {:.2f} deg): there the "
        "correction extrapolates",
        phi, all, phi == 1 ? "is" : "are", deg_from_rad(range.phi_low),
        deg_from_rad(range.phi_high)));
  }
  return words;
}

}  // namespace trammel::job
