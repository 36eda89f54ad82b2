#pragma once
// The size of the noise, and single readings that are not of it.

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/diagnose/residual_space.hpp"
#include "core/measure/reading.hpp"

namespace trammel {

/// What the base and the whole catalogue together leave, per kind of coordinate, over the stated
/// sigma.
struct NoiseRatio {
  double xy = 1, phi = 1;  // estimated over stated
  double xy_dof = 0, phi_dof = 0;
  double x = 1, y = 1;  // each by itself
  double x_dof = 0, y_dof = 0;
};
/// True where a ratio of estimated and stated sigma is not chance: dof ratio^2 outside the central
/// 1 - kOtherSize of chi^2(dof). (A standard error of ratio / sqrt(2 dof) is no such thing on few
/// degrees of freedom: a small ratio makes itself certain.) F(dof, noise_dof) where sigma comes
/// from repeats; noise_dof 0: it is known.
bool other_size(double ratio, double dof, double noise_dof = 0);
inline constexpr double kOtherSize = 0.001;

NoiseRatio noise_ratio(const ResidualSpace& space, const Eigen::MatrixXd& signals);

/// Correlation of the noise of successive readings, of either sign; 0 where there is none.
///
/// Successive readings agree (or alternate) more than base and catalogue let them (|z| >
/// kCorrelated), and still do once every trend, step and wave in time is fitted as well
/// (kNotACourse): a shift makes neighbours agree too, and is structure, not noise. rho is where
/// decorrelated residuals agree no more than white noise through the same projection. `known`: that
/// there is one need not be shown.
double noise_correlation(const std::function<ResidualSpace(double rho)>& space_with,
                         bool known = false);
inline constexpr double kCorrelated = 3.5;  // 0.05 % of clean campaigns, both signs
inline constexpr double kNotACourse = 2.0;

/// Places (in `space.readings`) of single bad readings, against base and catalogue fitted robustly.
///
/// Reading i stands out by d_i = r_i' (I - H_ii)^-1 r_i / scale^2, chi^2(k) of its coordinates;
/// scale from the median of all d. Bad: chance of one such reading in a clean campaign below
/// kFalseOutlier (or, where the rest has heavier tails than a normal distribution, ten sigmas).
/// More than kMostBad of the readings, or a run of successive ones, are no single readings: then
/// none is named.
std::vector<std::size_t> bad_readings(const ResidualSpace& space, const Eigen::MatrixXd& signals);
inline constexpr double kFalseOutlier = 0.0005;
inline constexpr double kMostBad = 0.15;

/// The readings as noise of heavy tails leaves them: each that lies farther than kWinsor sigmas
/// from base and catalogue fitted robustly is drawn in to that distance (Huber's
/// pseudo-observations, Robust Statistics 1981, sec. 7.8), so that least squares on them is a
/// robust fit.
struct Tails {
  std::vector<std::size_t> far;  // beyond what a normal distribution explains (kFalseOutlier)
  std::vector<std::size_t>
      gross;                      // of these, beyond what Student's t of 3 degrees explains as well
  std::vector<double> sigmas;     // of each in `far`
  std::vector<Reading> readings;  // drawn in
};
/// Nothing when the tails are a normal distribution's. Whether structure makes them is the caller's
/// question.
std::optional<Tails> heavy_tails(const ResidualSpace& space, const Eigen::MatrixXd& signals);
/// By the number of coordinates k: sqrt of chi^2(k), beyond which 5 % of normal readings lie.
inline constexpr std::array<double, 4> kWinsor = {0, 1.96, 2.45, 2.8};

}  // namespace trammel
