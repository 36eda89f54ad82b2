#include "core/measure/noise.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <tuple>
#include <vector>

#include "core/error.hpp"
#include "core/statistics/limits.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

constexpr double kSamePlaceMm = 1e-6;  // commands closer than this are one command

int sign(double v) { return v > kSamePlaceMm ? 1 : v < -kSamePlaceMm ? -1 : 0; }

constexpr double kSameDegc = 0.5;  // moves a steel rail of 300 mm by 2 um

/// Readings that should be equal but for noise: same epoch, command (to 1e-6 mm), approach and
/// temperature.
using Key = std::tuple<int, long long, long long, long long, int, int, int, long long>;

Key key_of(const Conditions& c) {
  const auto cell = [](double v) { return std::llround(v / kSamePlaceMm); };
  const Displacements move = c.cmd_mm - c.from_mm;
  return {c.epoch,           cell(c.cmd_mm[0]),
          cell(c.cmd_mm[1]), cell(c.cmd_mm[2]),
          sign(move[0]),     sign(move[1]),
          sign(move[2]),     c.temp_degc ? std::llround(*c.temp_degc / kSameDegc) : 0};
}

bool moved(const Conditions& c) {
  return (c.cmd_mm - c.from_mm).cwiseAbs().maxCoeff() > kSamePlaceMm;
}

/// Sums of squares about the mean of one group, or of several.
struct Scatter {
  double xy = 0, phi = 0;
  int freedom = 0;  // of phi

  void add(const Scatter& other, int times) {
    xy += times * other.xy;
    phi += times * other.phi;
    freedom += times * other.freedom;
  }
};

Scatter scatter_of(const std::vector<Eigen::Vector3d>& poses, const Coordinates& measured) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& pose : poses) mean += pose / static_cast<double>(poses.size());
  Scatter scatter{.freedom = static_cast<int>(poses.size()) - 1};
  for (const auto& pose : poses) {
    Eigen::Vector3d d = pose - mean;
    for (int c = 0; c < 3; ++c) {
      if (!measured[static_cast<std::size_t>(c)]) d[c] = 0;
    }
    scatter.xy += d.head<2>().squaredNorm();
    scatter.phi += d[2] * d[2];
  }
  return scatter;
}

/// Whether one variance is beyond another, both with their degrees of freedom.
bool beyond(double sum, int freedom, double other_sum, int other_freedom, double p) {
  if (freedom <= 0 || other_freedom <= 0) return false;
  return sum / freedom >
         variance_ratio_limit(p, freedom, other_freedom) * other_sum / other_freedom;
}

/// Leaves out the groups that scatter beyond all others, the worst first. Their number.
int leave_out_wild(std::vector<Scatter>& groups, Scatter& all, int n_xy) {
  const double p = kFalseGroup / static_cast<double>(2 * groups.size());
  const auto mean_square = [](const Scatter& s) { return s.xy / s.freedom; };
  const auto mean_phi = [](const Scatter& s) { return s.phi / s.freedom; };
  int left_out = 0;
  while (groups.size() > 1) {
    auto worst = std::ranges::max_element(groups, {}, mean_square);
    const auto is_wild = [&](const Scatter& g) {
      Scatter rest = all;
      rest.add(g, -1);
      return beyond(g.xy, n_xy * g.freedom, rest.xy, n_xy * rest.freedom, p) ||
             beyond(g.phi, g.freedom, rest.phi, rest.freedom, p);
    };
    if (!is_wild(*worst)) worst = std::ranges::max_element(groups, {}, mean_phi);
    if (!is_wild(*worst)) break;
    all.add(*worst, -1);
    groups.erase(worst);
    ++left_out;
  }
  return left_out;
}

enum class Against { as_stated, beyond, below };

/// An estimate from `degrees` of freedom against a sigma taken for known.
Against against(double estimate, double stated, double degrees) {
  const double chi2 = degrees * (estimate / stated) * (estimate / stated);
  if (chi2 > chi2_limit(kFalseRepeats, degrees)) return Against::beyond;
  return chi2 < chi2_limit(1 - kFalseRepeats, degrees) ? Against::below : Against::as_stated;
}

/// "0.0100 mm and 0.0040 deg"; without phi where it is not measured.
std::string both(const TrackerSigma& sigma) {
  constexpr double kSubMicrometre = 0.001;  // mm: below it four places would show nothing
  char text[80];
  std::snprintf(text, sizeof text, sigma.xy_mm < kSubMicrometre ? "%.3g mm" : "%.4f mm",
                sigma.xy_mm);
  if (sigma.phi_rad == 0) return text;
  std::string words = text;
  std::snprintf(text, sizeof text, " and %.4f deg", deg_from_rad(sigma.phi_rad));
  return words + text;
}

std::string words_of(const NoiseLevel& level, bool decided) {
  std::string text = "sigma per coordinate " + both(level.sigma) + ", ";
  std::string repeats;
  if (level.repeats) {
    const PooledNoise& r = *level.repeats;
    repeats = std::to_string(r.groups) + (r.groups == 1 ? " group" : " groups") +
              " of repeats (degrees of freedom: " + std::to_string(r.degrees_of_freedom) + ")";
    if (r.groups_left_out > 0) {
      repeats += ", " + std::to_string(r.groups_left_out) + " more left out as wild";
    }
  }
  if (!level.stated) return text + "from " + repeats;
  const std::string stated = both(*level.stated);
  if (level.source == NoiseLevel::Source::repeats) {
    return text + "since " + repeats + " give " + both(level.repeats->sigma) +
           ", beyond the stated " + stated + " by more than chance (1 %)";
  }
  text += "as stated for the tracker";
  if (!level.repeats) return text;
  text += "; " + repeats + " give " + both(level.repeats->sigma);
  if (level.doubted) {
    return text + ", less than chance leaves of it (1 %): is sigma in the right unit?";
  }
  return text + (decided ? ", which agrees (1 %)" : ", too few to decide");
}

void require_positive(const TrackerSigma& sigma, const Coordinates& measured) {
  const bool xy_ok =
      (!measured[0] && !measured[1]) || (std::isfinite(sigma.xy_mm) && sigma.xy_mm > 0);
  const bool phi_ok = !measured[2] || (std::isfinite(sigma.phi_rad) && sigma.phi_rad > 0);
  if (xy_ok && phi_ok) return;
  throw InputError({.what = "the tracker's standard deviation cannot weight a reading",
                    .where = {.field = xy_ok ? "tracker.sigma_phi_deg" : "tracker.sigma_xy_mm"},
                    .got = std::to_string(xy_ok ? deg_from_rad(sigma.phi_rad) : sigma.xy_mm),
                    .expected = "a positive number",
                    .hint = "state the tracker's sigma, or leave it out and measure repeats"});
}

}  // namespace

std::optional<PooledNoise> pooled_noise(std::span<const Reading> readings,
                                        const Coordinates& measured) {
  std::map<Key, std::vector<Eigen::Vector3d>> approached, standing;
  for (const Reading& reading : readings) {
    if (!reading.measured) continue;
    auto& repeats = moved(reading.conditions) ? approached : standing;
    repeats[key_of(reading.conditions)].push_back(reading.measured->vector());
  }
  std::vector<Scatter> groups;
  Scatter all;
  for (const auto* repeats : {&approached, &standing}) {
    if (!groups.empty()) break;
    for (const auto& [key, poses] : *repeats) {
      if (poses.size() < 2) continue;
      groups.push_back(scatter_of(poses, measured));
      all.add(groups.back(), 1);
    }
  }
  if (groups.empty()) return std::nullopt;
  PooledNoise noise;
  noise.n_xy = (measured[0] ? 1 : 0) + (measured[1] ? 1 : 0);
  noise.groups_left_out = leave_out_wild(groups, all, noise.n_xy);
  noise.groups = static_cast<int>(groups.size());
  noise.degrees_of_freedom = all.freedom;
  const double xy_freedom = std::max(noise.n_xy, 1) * 1.0 * all.freedom;
  noise.sigma = {.xy_mm = std::sqrt(all.xy / xy_freedom),
                 .phi_rad = std::sqrt(all.phi / all.freedom)};
  return noise;
}

NoiseLevel noise_level(const Campaign& campaign) {
  const Coordinates& measured = campaign.machine.measured;
  NoiseLevel level{.stated = campaign.tracker,
                   .repeats = pooled_noise(campaign.readings, measured)};
  const auto& repeats = level.repeats;
  bool decided = false;
  if (campaign.tracker) {
    require_positive(*campaign.tracker, measured);
    level.sigma = *campaign.tracker;
    decided = repeats && repeats->degrees_of_freedom >= kEnoughRepeats;
  } else if (repeats) {
    require_positive(repeats->sigma, measured);
    level.sigma = repeats->sigma;
    level.source = NoiseLevel::Source::repeats;
    level.degrees_of_freedom = repeats->degrees_of_freedom;
  } else {
    throw InputError({.what = "nothing says how well a reading is known",
                      .where = {.field = "tracker"},
                      .got = "no tracker sigmas, and no pose measured twice",
                      .expected = "tracker.sigma_xy_mm and tracker.sigma_phi_deg, or repeats"});
  }
  const auto settle = [&](double TrackerSigma::*of, int degrees) {
    const Against found = against(repeats->sigma.*of, level.sigma.*of, degrees);
    level.doubted = level.doubted || found == Against::below;
    if (found != Against::beyond) return;
    level.sigma.*of = repeats->sigma.*of;
    level.source = NoiseLevel::Source::repeats;
    level.degrees_of_freedom = repeats->degrees_of_freedom;
  };
  if (decided) {
    if (repeats->n_xy > 0)
      settle(&TrackerSigma::xy_mm, repeats->n_xy * repeats->degrees_of_freedom);
    if (measured[2]) settle(&TrackerSigma::phi_rad, repeats->degrees_of_freedom);
  }
  level.words = words_of(level, decided);
  return level;
}

}  // namespace trammel
