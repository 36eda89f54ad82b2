#include "core/calibrate/absorption.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "core/error.hpp"
#include "core/linear/decompositions.hpp"
#include "core/linear/products.hpp"
#include "core/linear/singular_values.hpp"
#include "core/statistics/limits.hpp"

namespace trammel {

namespace {

constexpr double kLeak = 0.05;  // of a parameter's direction may lie outside what is compared
constexpr double kNamed = 0.3;  // of a combination's largest share: named
constexpr std::size_t kMostNamed = 4;  // parameters of one alarm; the rest is counted
constexpr int kLeastDegrees = 20;  // of freedom within the halves: fewer give no noise to judge by
constexpr double kCommon = 1 - 1e-9;  // cosine of a direction that both halves know

/// The rows of one half, whitened and weighted, on the fit's identified directions.
struct Half {
  Eigen::VectorXd y;           // estimate, on what this half knows
  Eigen::MatrixXd covariance;  // of y
  Eigen::MatrixXd knows;       // orthonormal, shape (rank of the fit, rank of this half)
  double chi2 = 0;
  int dof = 0;
};

Half half_of(const Eigen::MatrixXd& B, const Eigen::VectorXd& r,
             const std::vector<Eigen::Index>& readings) {
  Eigen::MatrixXd rows(3 * static_cast<Eigen::Index>(readings.size()), B.cols());
  Eigen::VectorXd rest(rows.rows());
  Eigen::Index at = 0;
  for (const Eigen::Index i : readings) {
    rows.middleRows<3>(at) = B.middleRows<3>(3 * i);
    rest.segment<3>(at) = r.segment<3>(3 * i);
    at += 3;
  }
  // From B'B: directions above the limit are known to 1e-8 of the largest at worst, which is enough
  // to compare halves, and 1e5 readings stay cheap.
  const SymmetricEigen eigen = symmetric_eigen(gram(rows));
  const Eigen::VectorXd& s2 = eigen.values;
  const double least = std::max(kLeastSignal * kLeastSignal, 1e-12 * s2[s2.size() - 1]);
  const Eigen::Index rank = (s2.array() > least).count();
  Half half;
  half.knows = eigen.vectors.rightCols(rank);
  half.covariance = weighted_outer(half.knows, s2.tail(rank).cwiseInverse());
  half.y = times(half.covariance, transposed_times(rows, rest));
  half.chi2 = (rest - times(rows, half.y)).squaredNorm();
  half.dof = static_cast<int>(rows.rows() - rank);
  return half;
}

/// Orthonormal directions that both halves know.
Eigen::MatrixXd common(const Half& a, const Half& b) {
  const SingularValues cosines = singular_values(transposed_product(b.knows, a.knows));
  const Eigen::Index n = (cosines.singular.array() > kCommon).count();
  return product(a.knows, cosines.V.leftCols(n));
}

/// The largest members, "+0.81 l_1 -0.55 R_1 and 3 more (in tolerances)".
std::string combination_name(const Eigen::VectorXd& z, const std::vector<FreeParameter>& of) {
  std::vector<Eigen::Index> members;
  for (Eigen::Index k = 0; k < z.size(); ++k) {
    if (std::abs(z[k]) >= kNamed * z.cwiseAbs().maxCoeff()) members.push_back(k);
  }
  std::stable_sort(members.begin(), members.end(), [&z](Eigen::Index i, Eigen::Index j) {
    return std::abs(z[i]) > std::abs(z[j]);
  });
  std::string name;
  for (std::size_t m = 0; m < std::min(members.size(), kMostNamed); ++m) {
    char text[120];
    std::snprintf(text, sizeof text, "%s%+.2f %s", m == 0 ? "" : " ", z[members[m]],
                  of[static_cast<std::size_t>(members[m])].name.c_str());
    name += text;
  }
  if (members.size() > kMostNamed) {
    name += " and " + std::to_string(members.size() - kMostNamed) + " more";
  }
  return name + " (in tolerances)";
}

/// All shifts between two halves, in the directions `T` of the fit's identified ones `V`.
std::vector<HalfShift> all_shifts(const GeometryFit& fit, const Eigen::MatrixXd& V,
                                  const Eigen::MatrixXd& T, const Eigen::VectorXd& shift,
                                  const Eigen::MatrixXd& covariance) {
  const SymmetricEigen eigen = symmetric_eigen(product(transposed_product(T, covariance), T));
  std::vector<HalfShift> all;
  for (Eigen::Index k = 0; k < T.cols(); ++k) {
    const Eigen::VectorXd t = times(T, eigen.vectors.col(k));
    all.push_back({.name = combination_name(times(V, t), fit.parameters),
                   .single = false,
                   .is_angle = false,
                   .shift = t.dot(shift),
                   .standard_uncertainty = std::sqrt(eigen.values[k])});
  }
  for (std::size_t k = 0; k < fit.parameters.size(); ++k) {
    const FreeParameter& p = fit.parameters[k];
    const Eigen::VectorXd q = V.row(static_cast<Eigen::Index>(k)).transpose();
    const Eigen::VectorXd inside = within(T, q);
    // |q| = 1 when the fit knows the parameter by itself
    if (1 - q.squaredNorm() > kLeak * kLeak || (q - inside).norm() > kLeak) continue;
    all.push_back(
        {.name = p.name,
         .single = true,
         .unit = p.unit,
         .is_angle = p.unit == "deg" && p.kind != FreeParameter::Kind::effect,
         .shift = p.scale * inside.dot(shift),
         .standard_uncertainty = p.scale * std::sqrt(inside.dot(times(covariance, inside)))});
  }
  return all;
}

HalvesTest compare(const GeometryFit& fit, const Eigen::MatrixXd& V, const Eigen::MatrixXd& B,
                   const Eigen::VectorXd& r, const std::vector<Eigen::Index>& first,
                   const std::vector<Eigen::Index>& second, double false_alarm) {
  HalvesTest test;
  if (first.empty() || second.empty() || V.cols() == 0) {
    test.untested = "there are too few readings to halve";
    return test;
  }
  const Half a = half_of(B, r, first), b = half_of(B, r, second);
  const int dof = a.dof + b.dof;
  if (dof < kLeastDegrees) {
    test.untested = "too few readings to halve: " + std::to_string(dof) +
                    " degrees of freedom are left, " + std::to_string(kLeastDegrees) +
                    " are needed";
    return test;
  }
  const Eigen::MatrixXd T = common(a, b);
  if (T.cols() == 0) {
    test.untested = "no combination is identified by both halves";
    return test;
  }
  const double s2 = std::max(1.0, (a.chi2 + b.chi2) / dof);
  test.noise_ratio = std::sqrt(s2);
  test.shifts = all_shifts(fit, V, T, b.y - a.y, s2 * (a.covariance + b.covariance));
  test.tests = static_cast<int>(test.shifts.size());
  test.limit_sigmas = student_limit(false_alarm / test.tests, dof);
  std::erase_if(test.shifts,
                [&test](const HalfShift& s) { return std::abs(s.sigmas()) <= test.limit_sigmas; });
  std::stable_sort(test.shifts.begin(), test.shifts.end(),
                   [](const HalfShift& x, const HalfShift& y) {
                     return std::abs(x.sigmas()) > std::abs(y.sigmas());
                   });
  return test;
}

/// Places of the readings in the order they were taken.
std::vector<Eigen::Index> in_order(std::span<const Reading> readings) {
  std::vector<Eigen::Index> order(readings.size());
  std::iota(order.begin(), order.end(), 0);
  const bool timed = std::ranges::all_of(
      readings, [](const Reading& r) { return r.conditions.time_s.has_value(); });
  std::stable_sort(order.begin(), order.end(), [&](Eigen::Index i, Eigen::Index j) {
    const Reading& a = readings[static_cast<std::size_t>(i)];
    const Reading& b = readings[static_cast<std::size_t>(j)];
    return timed ? *a.conditions.time_s < *b.conditions.time_s : a.seq < b.seq;
  });
  return order;
}

}  // namespace

AbsorptionTest absorption_test(const GeometryFit& fit, std::span<const Reading> readings,
                               double false_alarm) {
  TRAMMEL_ASSERT(fit.system.residual.size() == static_cast<Eigen::Index>(3 * readings.size()));
  Eigen::MatrixXd J = fit.system.jacobian;
  Eigen::VectorXd r = fit.system.residual;
  for (Eigen::Index i = 0; i < fit.weights.size(); ++i) {
    const double root = std::sqrt(fit.weights[i]);
    J.middleRows<3>(3 * i) *= root;
    r.segment<3>(3 * i) *= root;
  }
  const Eigen::MatrixXd V = identifiable(J).directions;
  const Eigen::MatrixXd B = product(J, V);
  const std::vector<Eigen::Index> order = in_order(readings);
  const auto middle = order.begin() + static_cast<std::ptrdiff_t>(order.size() / 2);
  std::vector<Eigen::Index> even, odd;
  for (std::size_t k = 0; k < order.size(); ++k) (k % 2 == 0 ? even : odd).push_back(order[k]);
  return {
      .in_time = compare(fit, V, B, r, {order.begin(), middle}, {middle, order.end()}, false_alarm),
      .interleaved = compare(fit, V, B, r, even, odd, false_alarm),
      .false_alarm = false_alarm};
}

}  // namespace trammel
