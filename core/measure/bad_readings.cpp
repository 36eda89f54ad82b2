#include "core/measure/bad_readings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/linear/decompositions.hpp"
#include "core/linear/products.hpp"
#include "core/measure/lie.hpp"
#include "core/measure/nominal_commands.hpp"
#include "core/measure/printed.hpp"
#include "core/statistics/robust.hpp"
#include "core/statistics/tail.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

constexpr int kMostDegree = 3;              // geometry and guides bend it no more within noise
constexpr double kRowsPerTerm = 2.5;        // fewer rows would follow the bad ones
constexpr std::size_t kFewestOfField = 8;   // a plane of three terms
constexpr std::size_t kFewestOfMedian = 5;  // two wrong ones of five leave it where it is
constexpr int kRounds = 12;                 // a bound: it ends where the set stands still
constexpr double kWorthALook = 4;           // scales: where none is farther, none bends the field
constexpr int kReweighted = 30;             // least absolute deviations stand still by then
constexpr double kLeastSize = 0.3;          // of the scale: smaller residuals have one weight
constexpr double kTinyScale = 1e-9;         // mm, rad: where most readings lie on the field
constexpr double kScaleOfFieldMm = 100;     // for the condition of the equations alone
constexpr std::array<double, 3> kLeastFar = {0.05, 0.05, rad_from_deg(0.02)};  // mm, mm, rad
// mm, mm, rad: frames, joint zeros and leads included
constexpr std::array<double, 3> kNoMachineErrs = {kMostCorrectionMm, kMostCorrectionMm,
                                                  rad_from_deg(2)};
constexpr double kOtherTargetMm = 0.1;                 // nearer, one pose can serve two targets
constexpr double kOtherTargetRad = rad_from_deg(0.1);  // the same of orientations

constexpr double kNearScales = 6;    // what is farther says nothing of the tails of the rest
constexpr double kHeavyTails = 4;    // standard errors of the excess kurtosis
constexpr double kFalseFar = 0.005;  // of campaigns with Student's noise of 3 degrees

using Rows = std::vector<const Reading*>;

Eigen::Vector3d deviation_of(const Reading& r) {
  Eigen::Vector3d d = r.measured->vector() - r.target.vector();
  d[2] = std::remainder(d[2], 2 * kPi);
  return d;
}

std::map<int, Rows> by_epoch(const Campaign& campaign) {
  std::map<int, Rows> epochs;
  for (const Reading& r : campaign.readings) {
    if (r.measured) epochs[r.conditions.epoch].push_back(&r);
  }
  return epochs;
}

/// x^a y^b with a + b <= degree, and phi, phi^2, phi x, phi y where orientations vary.
Eigen::MatrixXd terms_of(std::span<const Pose> targets, int degree, bool turns) {
  std::vector<std::array<int, 2>> powers;
  for (int a = 0; a <= degree; ++a) {
    for (int b = 0; a + b <= degree; ++b) powers.push_back({a, b});
  }
  const auto n_powers = static_cast<Eigen::Index>(powers.size());
  Eigen::MatrixXd A(static_cast<Eigen::Index>(targets.size()), n_powers + (turns ? 4 : 0));
  for (Eigen::Index k = 0; k < A.rows(); ++k) {
    const Pose& t = targets[static_cast<std::size_t>(k)];
    const double x = t.x_mm / kScaleOfFieldMm, y = t.y_mm / kScaleOfFieldMm;
    for (Eigen::Index c = 0; c < n_powers; ++c) {
      const auto& power = powers[static_cast<std::size_t>(c)];
      A(k, c) = std::pow(x, power[0]) * std::pow(y, power[1]);
    }
    if (turns) A.row(k).tail<4>() << t.phi_rad, t.phi_rad * t.phi_rad, t.phi_rad * x, t.phi_rad * y;
  }
  return A;
}

double sigma_of(const Eigen::VectorXd& left, const std::vector<bool>& keep) {
  std::vector<double> size;
  for (Eigen::Index k = 0; k < left.size(); ++k) {
    if (keep[static_cast<std::size_t>(k)]) size.push_back(left[k]);
  }
  return robust_sigma(std::move(size));
}

/// Deviations less the smooth field of the readings that are not far from it.
struct Field {
  Rows rows = {};
  Eigen::MatrixXd left = {};  // mm, mm, rad by row
  Eigen::Vector3d sigma = Eigen::Vector3d::Zero();
  std::vector<bool> keep = {};
  int terms = 0;
};

/// What the weighted least squares of `off` on A leave, column by column.
Eigen::MatrixXd left_of(const Eigen::MatrixXd& A, const Eigen::MatrixXd& off,
                        const Eigen::VectorXd& weights) {
  Eigen::MatrixXd left = off;
  const Eigen::MatrixXd weighted = weights.asDiagonal() * A;
  const Eigen::MatrixXd normal = transposed_product(weighted, A);
  for (Eigen::Index c = 0; c < off.cols(); ++c) {
    left.col(c) -= times(A, solve_symmetric(normal, transposed_times(weighted, off.col(c))));
  }
  return left;
}

/// Readings that no field need be asked about: so far from the median deviation, and farther than
/// any machine errs. Two of ten would bend the field to themselves.
std::vector<bool> not_wild(const Eigen::MatrixXd& off) {
  std::vector<bool> keep(static_cast<std::size_t>(off.rows()), true);
  for (Eigen::Index c = 0; c < off.cols(); ++c) {
    const Eigen::VectorXd column = off.col(c);
    const double middle = median({column.begin(), column.end()});
    const Eigen::VectorXd about = (column.array() - middle).abs();
    const double limit = std::max(kFarTimes * median({about.begin(), about.end()}),
                                  kNoMachineErrs[static_cast<std::size_t>(c)]);
    for (Eigen::Index k = 0; k < off.rows(); ++k) {
      if (about[k] > limit) keep[static_cast<std::size_t>(k)] = false;
    }
  }
  return keep;
}

/// Least absolute deviations, by weights 1 / |r| (Schlossmacher 1973), |r| the largest coordinate
/// of the reading over its robust scale: several wrong readings in one corner bend the least
/// squares to themselves, these not.
Eigen::MatrixXd left_of_most(const Eigen::MatrixXd& A, const Eigen::MatrixXd& off,
                             const std::vector<bool>& tame) {
  Eigen::VectorXd tame_alone(off.rows());
  for (Eigen::Index k = 0; k < off.rows(); ++k)
    tame_alone[k] = tame[static_cast<std::size_t>(k)] ? 1 : 0;
  Eigen::VectorXd weights = tame_alone;
  Eigen::MatrixXd left;
  for (int round = 0; round < kReweighted; ++round) {
    left = left_of(A, off, weights);
    Eigen::VectorXd size = Eigen::VectorXd::Constant(off.rows(), kLeastSize);
    for (Eigen::Index c = 0; c < off.cols(); ++c) {
      const double sigma = std::max(sigma_of(left.col(c), tame), kTinyScale);
      size = size.cwiseMax(left.col(c).cwiseAbs() / sigma);
    }
    if (round == 0 && size.cwiseProduct(tame_alone).maxCoeff() < kWorthALook) break;
    weights = size.cwiseInverse().cwiseProduct(tame_alone);
  }
  return left;
}

/// Scales beyond which a coordinate is far: kFarTimes, but where what lies near has heavier tails
/// than a normal distribution as far as Student's t of 3 degrees goes in kFalseFar of campaigns.
double far_times(const Field& f) {
  constexpr double kScaleOfStudent3 = 1.134;  // robust_sigma of it
  Kurtosis near;
  for (Eigen::Index c = 0; c < 3; ++c) {
    for (Eigen::Index k = 0; k < f.left.rows(); ++k) {
      const double u = f.left(k, c) / std::max(f.sigma[c], kTinyScale);
      if (std::abs(u) <= kNearScales) near.add(u);
    }
  }
  if (near.in_errors() < kHeavyTails) return kFarTimes;
  const auto coordinates = static_cast<double>(f.left.size());
  return std::max(kFarTimes, student3_reach(coordinates, kFalseFar) / kScaleOfStudent3);
}

/// What is near whatever scatters, mm, mm, rad: less where the noise is known to be.
std::array<double, 3> least_far(const Campaign& campaign) {
  if (!campaign.tracker) return kLeastFar;
  const TrackerSigma& sigma = *campaign.tracker;
  std::array<double, 3> least = kLeastFar;
  const std::array<double, 3> of_noise = {sigma.xy_mm, sigma.xy_mm, sigma.phi_rad};
  for (std::size_t c = 0; c < least.size(); ++c) {
    if (of_noise[c] > 0) least[c] = std::min(least[c], kFarTimes * of_noise[c]);
  }
  return least;
}

Field field_of(const Rows& rows, const std::array<double, 3>& least_far) {
  Field f{.rows = rows};
  const auto n = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd off(n, 3);
  std::vector<Pose> targets;
  for (Eigen::Index k = 0; k < n; ++k) {
    const Reading& r = *rows[static_cast<std::size_t>(k)];
    off.row(k) = deviation_of(r).transpose();
    targets.push_back(r.target);
  }
  const Eigen::MatrixXd A = smooth_terms(targets);
  f.terms = static_cast<int>(A.cols());
  const std::vector<bool> tame = not_wild(off);
  f.left = left_of_most(A, off, tame);
  f.keep = tame;
  // Few rows have but a mean, and errors of machines are no constant.
  const int rounds = rows.size() < kFewestOfField ? 1 : kRounds;
  for (int round = 0; round < rounds; ++round) {
    std::vector<bool> keep = tame;
    for (int c = 0; c < 3; ++c) f.sigma[c] = sigma_of(f.left.col(c), f.keep);
    const double times = far_times(f);
    for (int c = 0; c < 3; ++c) {
      const double least = (rounds == 1 ? kNoMachineErrs : least_far)[static_cast<std::size_t>(c)];
      const double limit = std::max(times * f.sigma[c], least);
      for (Eigen::Index k = 0; k < n; ++k) {
        if (std::abs(f.left(k, c)) > limit) keep[static_cast<std::size_t>(k)] = false;
      }
    }
    if (round > 0 && keep == f.keep) break;
    f.keep = std::move(keep);
    Eigen::VectorXd used(n);
    for (Eigen::Index k = 0; k < n; ++k) used[k] = f.keep[static_cast<std::size_t>(k)] ? 1 : 0;
    f.left = left_of(A, off, used);
  }
  return f;
}

double way_mm(const Pose& a, const Pose& b) { return std::hypot(a.x_mm - b.x_mm, a.y_mm - b.y_mm); }

bool other_place(const Pose& a, const Pose& b) {
  return way_mm(a, b) > kOtherTargetMm || std::abs(a.phi_rad - b.phi_rad) > kOtherTargetRad;
}

/// Two readings one after the other with one pose for two targets: the one that is farther off.
void add_stale(const Campaign& campaign, std::vector<Suspicion>& found) {
  const Reading* before = nullptr;
  for (const Reading& r : campaign.readings) {
    if (!r.measured) continue;
    if (before && *before->measured == *r.measured && other_place(before->target, r.target)) {
      const bool later = deviation_of(*before).squaredNorm() < deviation_of(r).squaredNorm();
      const Reading& bad = later ? r : *before;
      const Reading& good = later ? *before : r;
      found.push_back({Mistake::stale,
                       printed("repeats the pose of seq %d to the last digit", good.seq),
                       printed("it was asked for a pose %.3g mm away, and stands %.3g mm from it",
                               way_mm(r.target, before->target), way_mm(*bad.measured, bad.target)),
                       {bad.seq}});
    }
    before = &r;
  }
}

void add_missed(const Campaign& campaign, std::vector<Suspicion>& found) {
  for (const Reading& r : campaign.readings) {
    if (!r.measured || !(*r.measured == Pose{}) || !other_place(r.target, Pose{})) continue;
    found.push_back({Mistake::missed,
                     "reads 0, 0, 0: the tracker saw nothing",
                     printed("its target is %.3g mm away", way_mm(r.target, Pose{})),
                     {r.seq}});
  }
}

void add_far_commands(const Campaign& c, std::vector<Suspicion>& found) {
  const std::vector<double> off_mm = command_off_mm(c);
  for (std::size_t k = 0; k < off_mm.size(); ++k) {
    if (!single_far_command(off_mm, k)) continue;
    found.push_back({Mistake::far,
                     "its command is not that of its target",
                     printed("it is %.3g mm off, which no correction is", off_mm[k]),
                     {c.readings[k].seq}});
  }
}

void add_far(const Field& f, std::vector<Suspicion>& found) {
  for (std::size_t k = 0; k < f.rows.size(); ++k) {
    const int seq = f.rows[k]->seq;
    if (f.keep[k] ||
        std::ranges::any_of(found, [seq](const Suspicion& s) { return s.seqs.front() == seq; }))
      continue;
    const Eigen::Vector3d left = f.left.row(static_cast<Eigen::Index>(k)).transpose();
    const double times = (left.cwiseAbs().array() / f.sigma.array().max(1e-12)).maxCoeff();
    found.push_back({Mistake::far,
                     "has no good neighbour",
                     printed("%.3g mm and %.3g deg from what the others have about its place, %.3g "
                             "times their scatter",
                             left.head<2>().norm(), deg_from_rad(std::abs(left[2])), times),
                     {seq}});
  }
}

}  // namespace

Eigen::MatrixXd smooth_terms(std::span<const Pose> targets) {
  const auto phi_of = [](const Pose& p) { return p.phi_rad; };
  const auto [low, high] = std::ranges::minmax_element(targets, {}, phi_of);
  const bool turns = high->phi_rad - low->phi_rad > poses::kOneOrientationRad;
  for (int degree = kMostDegree;; --degree) {
    Eigen::MatrixXd A = terms_of(targets, degree, degree > 0 && turns);
    const bool enough =
        kRowsPerTerm * static_cast<double>(A.cols()) <= static_cast<double>(A.rows());
    if (enough || degree == 0) return A;
  }
}

std::vector<Suspicion> bad_readings(const Campaign& campaign) {
  std::vector<Suspicion> found;
  add_stale(campaign, found);
  add_missed(campaign, found);
  add_far_commands(campaign, found);
  for (const auto& [epoch, rows] : by_epoch(campaign)) {
    if (rows.size() >= kFewestOfMedian) add_far(field_of(rows, least_far(campaign)), found);
  }
  return found;
}

SmoothResidual smooth_residual(const Campaign& campaign) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int dof = 0;
  for (const auto& [epoch, rows] : by_epoch(campaign)) {
    const Field f = field_of(rows, least_far(campaign));
    const auto kept = std::ranges::count(f.keep, true);
    const int free = static_cast<int>(kept) - f.terms;
    if (free <= 0) continue;
    // Least squares leaves free / kept of the variance.
    sum += static_cast<double>(kept) * f.sigma.cwiseAbs2();
    dof += free;
  }
  if (dof == 0) return {};
  const Eigen::Vector3d sigma = (sum / dof).cwiseSqrt();
  return {.x_mm = sigma[0], .y_mm = sigma[1], .phi_rad = sigma[2], .degrees_of_freedom = dof};
}

}  // namespace trammel
