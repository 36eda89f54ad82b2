#include "core/measure/noise.hpp"

#include <cmath>
#include <cstdio>
#include <map>
#include <tuple>
#include <vector>

#include "core/error.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

constexpr double kSamePlaceMm = 1e-6;  // commands closer than this are one command

int sign(double v) { return v > kSamePlaceMm ? 1 : v < -kSamePlaceMm ? -1 : 0; }

/// Readings that should be equal but for noise: same epoch, command (to 1e-6 mm) and approach.
using Key = std::tuple<int, long long, long long, long long, int, int, int>;

Key key_of(const Conditions& c) {
  const auto cell = [](double v) { return std::llround(v / kSamePlaceMm); };
  const Displacements move = c.cmd_mm - c.from_mm;
  return {c.epoch,       cell(c.cmd_mm[0]), cell(c.cmd_mm[1]), cell(c.cmd_mm[2]),
          sign(move[0]), sign(move[1]),     sign(move[2])};
}

std::string words_of(const TrackerSigma& sigma, const std::string& source) {
  char text[160];
  std::snprintf(text, sizeof text, "%s: %.4f mm and %.4f deg (one standard deviation)",
                source.c_str(), sigma.xy_mm, deg_from_rad(sigma.phi_rad));
  return text;
}

void require_positive(const TrackerSigma& sigma) {
  const bool xy_ok = std::isfinite(sigma.xy_mm) && sigma.xy_mm > 0;
  const bool phi_ok = std::isfinite(sigma.phi_rad) && sigma.phi_rad > 0;
  if (xy_ok && phi_ok) return;
  throw InputError({.what = "the tracker's standard deviation cannot weight a reading",
                    .where = {.field = xy_ok ? "tracker.sigma_phi_deg" : "tracker.sigma_xy_mm"},
                    .got = std::to_string(xy_ok ? deg_from_rad(sigma.phi_rad) : sigma.xy_mm),
                    .expected = "a positive number",
                    .hint = "state the tracker's sigma, or leave it out and measure repeats"});
}

}  // namespace

std::optional<PooledNoise> pooled_noise(std::span<const Reading> readings) {
  std::map<Key, std::vector<Eigen::Vector3d>> groups;
  for (const Reading& reading : readings) {
    if (reading.measured) {
      groups[key_of(reading.conditions)].push_back(reading.measured->vector());
    }
  }
  PooledNoise noise;
  double sum_xy = 0, sum_phi = 0;
  for (const auto& [key, poses] : groups) {
    if (poses.size() < 2) continue;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const auto& pose : poses) mean += pose / static_cast<double>(poses.size());
    for (const auto& pose : poses) {
      const Eigen::Vector3d d = pose - mean;
      sum_xy += d[0] * d[0] + d[1] * d[1];
      sum_phi += d[2] * d[2];
    }
    noise.degrees_of_freedom += static_cast<int>(poses.size()) - 1;
    ++noise.groups;
  }
  if (noise.groups == 0) return std::nullopt;
  noise.sigma = {.xy_mm = std::sqrt(sum_xy / (2.0 * noise.degrees_of_freedom)),
                 .phi_rad = std::sqrt(sum_phi / noise.degrees_of_freedom)};
  return noise;
}

NoiseLevel noise_level(const Campaign& campaign) {
  if (campaign.tracker) {
    require_positive(*campaign.tracker);
    return {.sigma = *campaign.tracker,
            .source = NoiseLevel::Source::tracker,
            .words = words_of(*campaign.tracker, "tracker as stated")};
  }
  const auto repeats = pooled_noise(campaign.readings);
  if (!repeats) {
    throw InputError({.what = "nothing says how well a reading is known",
                      .where = {.field = "tracker"},
                      .got = "no tracker sigmas, and no pose measured twice",
                      .expected = "tracker.sigma_xy_mm and tracker.sigma_phi_deg, or repeats"});
  }
  require_positive(repeats->sigma);
  return {.sigma = repeats->sigma,
          .source = NoiseLevel::Source::repeats,
          .degrees_of_freedom = repeats->degrees_of_freedom,
          .words = words_of(repeats->sigma, "estimated from " + std::to_string(repeats->groups) +
                                                " groups of repeats, " +
                                                std::to_string(repeats->degrees_of_freedom) +
                                                " degrees of freedom")};
}

}  // namespace trammel
