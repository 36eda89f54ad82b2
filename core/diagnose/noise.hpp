#pragma once
// The size of the noise, and single readings that are not of it.

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/diagnose/residual_space.hpp"
#include "core/measure/reading.hpp"

namespace trammel {

/// What the base and the whole catalogue together leave, per kind of coordinate, over the stated
/// sigma.
struct NoiseRatio {
  double xy = 1, phi = 1;      // estimated over stated
  double u_xy = 0, u_phi = 0;  // standard uncertainties
};
NoiseRatio noise_ratio(const ResidualSpace& space, const Eigen::MatrixXd& signals);

/// Correlation of the noise of successive readings; 0 where there is none.
///
/// Successive readings agree more than base and catalogue let them (z > kCorrelated), and still do
/// once every trend, step and wave in time is fitted as well (z > kNotACourse): a shift makes
/// neighbours agree too, and is structure, not noise. rho is where decorrelated residuals agree no
/// more than white noise through the same projection.
/// `known`: that there is one need not be shown.
double noise_correlation(const std::function<ResidualSpace(double rho)>& space_with,
                         bool known = false);
inline constexpr double kCorrelated = 3.5;  // 0.02 % of clean campaigns
inline constexpr double kNotACourse = 2.0;

/// Places (in `space.readings`) of single bad readings, against base and catalogue fitted robustly.
///
/// Reading i stands out by d_i = r_i' (I - H_ii)^-1 r_i / scale^2, chi^2(3) for a good one; scale
/// from the median of all d. Bad: chance of one such reading in a clean campaign below
/// kFalseOutlier (or, where the rest has heavier tails than a normal distribution, ten sigmas).
/// More than kMostBad of the readings, or a run of successive ones, are no single readings: then
/// none is named.
std::vector<std::size_t> bad_readings(const ResidualSpace& space, const Eigen::MatrixXd& signals);
inline constexpr double kFalseOutlier = 0.0005;
inline constexpr double kMostBad = 0.15;

}  // namespace trammel
