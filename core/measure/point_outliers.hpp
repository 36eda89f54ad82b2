#pragma once
// Misses and gross outliers among points that a tracker took of one place.

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

namespace trammel {

/// A point that a tracker writes when it saw nothing: exactly 0, 0, 0 (its own centre).
inline bool is_miss(const Eigen::Vector3d& point_mm) { return (point_mm.array() == 0).all(); }

/// The rule by which a point of a resting reflector is a gross outlier.
///   m = median per coordinate,  r_i = |p_i - m|,  MAD = median r_i
///   outlier:  r_i > max(times MAD, least_mm)
/// With normal noise of sigma in three coordinates MAD is 1.54 sigma: the limit stands at 15 sigma.
/// It is for what is no measurement of this place (a ghost, the wrong nest), never for the tails.
struct OutlierRule {
  double times = 10;
  double least_mm = 0.1;  // nearer is no gross outlier, however quiet the others are
  int least_n = 5;        // fewer points don't say which of them is wrong
};

struct Screened {
  Eigen::Vector3d median_mm = Eigen::Vector3d::Zero();
  double mad_mm = 0;
  std::optional<double> limit_mm = {};     // none: too few points to judge
  std::vector<std::size_t> outliers = {};  // places in the input, rising
};

/// Applies the rule to points of one place, misses taken out before. Holds while fewer than half of
/// the points are wrong. Proof: finds what was put in; of sets of 10 normal points fewer than one
/// in 2,000 loses a point (point_outliers_test.cpp).
Screened screen(std::span<const Eigen::Vector3d> points_mm, const OutlierRule& rule = {});

}  // namespace trammel
