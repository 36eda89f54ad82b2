#include "tests/study/foreign.hpp"

#include <cmath>

#include "core/mechanism/inverse.hpp"
#include "core/statistics/random.hpp"
#include "core/units.hpp"

namespace trammel::tests {

namespace {

constexpr double kHalfMm = 60;
constexpr int kFitted = 150, kUnseen = 40;

/// Errors over the half travel, 1: at u = x / half and v = y / half of the stage's axes.
struct StageErrors {
  double squareness, scale_x, scale_y, curve_x, curve_y, bow_x, bow_y, yaw;
};

StageErrors draw(Random& random, const ForeignDesign& design) {
  const auto one = [&] {
    return design.size * random.uniform(0.3, 1) * (random.uniform() < 0.5 ? 1 : -1);
  };
  StageErrors e{one(), one(), one(), one(), one(), one(), one(), one()};
  if (!design.yaws) e.yaw = 0;
  return e;
}

/// Where the stage goes: x carries y, so that the yaw of x moves what y carries (Abbe).
Pose reached(const StageErrors& e, const Pose& target) {
  const double u = target.x_mm / kHalfMm, v = target.y_mm / kHalfMm;
  const double yaw = e.yaw * u;
  return {target.x_mm +
              kHalfMm * (e.squareness * v + e.scale_x * u + e.curve_x * u * u + e.bow_y * v * v) -
              yaw * target.y_mm,
          target.y_mm + kHalfMm * (e.scale_y * v + e.curve_y * v * v + e.bow_x * u * u),
          target.phi_rad + yaw};
}

}  // namespace

HiddenCase make_foreign(const ForeignDesign& design, std::uint64_t seed) {
  Random random = Random::stream(seed, "foreign");
  const StageErrors errors = draw(random, design);
  HiddenCase result;
  result.hidden = {"xy_stage"};
  result.in_catalogue = false;
  result.truth.tracker.sigma_xy_mm = design.sigma_xy_mm;
  result.truth.tracker.sigma_phi_rad = rad_from_deg(design.sigma_phi_deg);
  Campaign& campaign = result.campaign;
  campaign.name = "foreign-" + std::to_string(seed);
  campaign.simulated = true;
  campaign.machine = machine_of(paper_mechanism());
  campaign.tracker = TrackerSigma{design.sigma_xy_mm, rad_from_deg(design.sigma_phi_deg)};
  for (int i = 0; i < kFitted + kUnseen; ++i) {
    Reading r;
    r.seq = i + 1;
    r.set = i < kFitted ? ReadingSet::identify : ReadingSet::validate;
    r.target = {random.uniform(-kHalfMm, kHalfMm), random.uniform(-kHalfMm, kHalfMm),
                design.turns ? rad_from_deg(6.0 * (static_cast<int>(random.below(3)) - 1)) : 0};
    r.conditions.cmd_mm = inverse(mechanism_of(campaign.machine).geometry, r.target).l_mm;
    r.conditions.from_mm = r.conditions.cmd_mm;
    for (double& from : r.conditions.from_mm) {
      const double length = std::exp(random.uniform(0, std::log(30)));
      from -= random.uniform() < 0.5 ? length : -length;
    }
    r.conditions.time_s = 45.0 * i;
    r.conditions.temp_degc = 20 + 1.5 * std::sin(2 * kPi * i / 120.0);
    r.measured = reached(errors, r.target);
    result.still.push_back(r);
    r.measured->x_mm += design.sigma_xy_mm * random.normal();
    r.measured->y_mm += design.sigma_xy_mm * random.normal();
    r.measured->phi_rad += rad_from_deg(design.sigma_phi_deg) * random.normal();
    campaign.readings.push_back(r);
  }
  return result;
}

}  // namespace trammel::tests
