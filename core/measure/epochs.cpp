#include "core/measure/epochs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <string>

#include "core/error.hpp"
#include "core/linear/decompositions.hpp"
#include "core/linear/least_squares.hpp"
#include "core/measure/held_epochs.hpp"
#include "core/statistics/limits.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

constexpr int kHighestDegree = 4;    // of the smooth error
constexpr int kReadingsPerTerm = 4;  // as many again for the noise, and more
constexpr double kRankShare = 1e-9;  // of the longest column: what is shorter is rounding
constexpr double kSameMm = 1e-6;     // a coordinate that varies less is one value

/// Powers of up to three coordinates with a sum of at most `degree`.
int n_terms(int coordinates, int degree) {
  int terms = 1;  // (degree + coordinates) choose coordinates
  for (int k = 1; k <= coordinates; ++k) terms = terms * (degree + k) / k;
  return terms;
}

/// Coordinates that vary, each from -1 to 1, shape (n, coordinates).
Eigen::MatrixXd scaled_places(std::span<const Reading> readings) {
  Eigen::MatrixXd all(static_cast<Eigen::Index>(readings.size()), 3);
  for (std::size_t j = 0; j < readings.size(); ++j) {
    all.row(static_cast<Eigen::Index>(j)) = readings[j].target.vector().transpose();
  }
  Eigen::Index n = 0;
  for (Eigen::Index c = 0; c < 3; ++c) {
    const double low = all.col(c).minCoeff(), high = all.col(c).maxCoeff();
    if (high - low < kSameMm) continue;
    all.col(n++) = (2 * all.col(c).array() - low - high) / (high - low);
  }
  return all.leftCols(n);
}

/// Monomials of degree 0 … `degree`, one column each, shape (n, n_terms).
Eigen::MatrixXd monomials(const Eigen::MatrixXd& places, int degree) {
  const int coordinates = static_cast<int>(places.cols());
  Eigen::MatrixXd terms(places.rows(), n_terms(coordinates, degree));
  Eigen::Index next = 0;
  for (int a = 0; a <= degree; ++a) {
    for (int b = 0; b <= (coordinates > 1 ? degree - a : 0); ++b) {
      for (int c = 0; c <= (coordinates > 2 ? degree - a - b : 0); ++c) {
        Eigen::ArrayXd term = Eigen::ArrayXd::Ones(places.rows());
        const int powers[3] = {a, b, c};
        for (int k = 0; k < coordinates; ++k) {
          for (int p = 0; p < powers[k]; ++p) term *= places.col(k).array();
        }
        terms.col(next++) = term;
      }
    }
  }
  return terms.leftCols(next);
}

struct Left {
  double sum_of_squares = 0;
  int rank = 0;
};

/// What min |A z - b| leaves, by the columns that are more than rounding.
Left left_by(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  const PivotedQr qr = pivoted_qr(A, b, static_cast<int>(A.cols()));
  Left left{.sum_of_squares = qr.left2, .rank = 0};
  for (Eigen::Index k = 0; k < qr.R.rows(); ++k) {
    if (std::abs(qr.R(k, k)) > kRankShare * std::abs(qr.R(0, 0))) {
      ++left.rank;
    } else {
      left.sum_of_squares += qr.Qb[k] * qr.Qb[k];
    }
  }
  return left;
}

/// Where the nominal machine stands under the command.
MachineAt nominal_pose(const NominalMachine& machine, const Reading& reading, bool with_jacobian) {
  MachineAt at = machine.at(reading.conditions.cmd_mm, reading.target, with_jacobian);
  if (at.ok()) return at;
  throw InputError({.what = "the commanded displacements are out of the nominal robot's reach",
                    .where = {.point = "seq " + std::to_string(reading.seq)}});
}

/// measured - forward(cmd), shape (n, 3); 0 in coordinates that are not measured.
Eigen::MatrixXd deviations(const NominalMachine& machine, std::span<const Reading> readings) {
  Eigen::MatrixXd d(static_cast<Eigen::Index>(readings.size()), 3);
  for (std::size_t j = 0; j < readings.size(); ++j) {
    const Pose stands = nominal_pose(machine, readings[j], false).pose;
    Eigen::Vector3d step =
        machine.measured_else(*readings[j].measured, stands).vector() - stands.vector();
    step[2] = std::remainder(step[2], 2 * kPi);
    d.row(static_cast<Eigen::Index>(j)) = step.transpose();
  }
  return d;
}

Eigen::MatrixXd directions(std::span<const Reading> readings) {
  Eigen::MatrixXd dir(static_cast<Eigen::Index>(readings.size()), kChains);
  for (std::size_t j = 0; j < readings.size(); ++j) {
    const Conditions& c = readings[j].conditions;
    dir.row(static_cast<Eigen::Index>(j)) = directions_of(c.cmd_mm - c.from_mm).transpose();
  }
  return dir;
}

/// Readings with a pose, and the numbers of their epochs after the first.
struct Measured {
  std::vector<Reading> readings;
  int first_epoch = 0;
  std::set<int> later_epochs;
};

Measured measured_of(std::span<const Reading> readings) {
  Measured m;
  for (const Reading& r : readings) {
    if (!r.measured) continue;
    m.readings.push_back(r);
    m.later_epochs.insert(r.conditions.epoch);
  }
  if (m.later_epochs.empty()) return m;
  m.first_epoch = *m.later_epochs.begin();
  m.later_epochs.erase(m.later_epochs.begin());
  return m;
}

/// Columns of the robot's error: a smooth function of the place, and the direction of approach.
struct Smooth {
  int degree = 0;
  Eigen::MatrixXd columns;
};

Smooth smooth_of(std::span<const Reading> readings) {
  const Eigen::MatrixXd places = scaled_places(readings);
  const auto n = static_cast<int>(readings.size());
  Smooth smooth{.degree = kHighestDegree, .columns = {}};
  while (smooth.degree > 0 &&
         kReadingsPerTerm * n_terms(static_cast<int>(places.cols()), smooth.degree) > n) {
    --smooth.degree;
  }
  const Eigen::MatrixXd terms = monomials(places, smooth.degree);
  smooth.columns.resize(n, terms.cols() + kChains);
  smooth.columns << terms, directions(readings);
  return smooth;
}

constexpr int kShift = 6;                                       // joint zeros, then the frame
constexpr double kPrior[kShift] = {0.1, 0.1, 0.1, 1, 1, 0.01};  // mm, mm, rad

/// What a shift does to each coordinate of the readings of its epoch: three blocks of shape (n,
/// kShift epochs).
std::array<Eigen::MatrixXd, 3> shift_columns(const NominalMachine& machine, const Measured& m) {
  const auto n = static_cast<Eigen::Index>(m.readings.size());
  std::array<Eigen::MatrixXd, 3> columns;
  columns.fill(Eigen::MatrixXd::Zero(n, kShift * static_cast<Eigen::Index>(m.later_epochs.size())));
  for (Eigen::Index j = 0; j < n; ++j) {
    const Reading& r = m.readings[static_cast<std::size_t>(j)];
    const auto epoch = m.later_epochs.find(r.conditions.epoch);
    if (epoch == m.later_epochs.end()) continue;
    const MachineAt at = nominal_pose(machine, r, true);
    Eigen::Matrix<double, 3, kShift> by;
    by.leftCols<3>() = at.J_V;
    by.rightCols<3>() << 1, 0, -at.pose.y_mm, 0, 1, at.pose.x_mm, 0, 0, 1;
    const auto first = kShift * std::distance(m.later_epochs.begin(), epoch);
    for (int c = 0; c < 3; ++c) {
      columns[static_cast<std::size_t>(c)].row(j).segment<kShift>(first) = by.row(c);
    }
  }
  return columns;
}

/// Is there a step between the epochs of `group`, the others standing where they like? The variance
/// ratio at `level`, over the coordinates. Nothing with too few readings.
std::optional<bool> step_between(const NominalMachine& machine, const Measured& m,
                                 const std::set<int>& group, double level) {
  const auto n = static_cast<int>(m.readings.size());
  const auto n_later = static_cast<int>(m.later_epochs.size());
  if (n == 0) return std::nullopt;
  const Smooth smooth = smooth_of(m.readings);
  if (smooth.degree == 0 || n <= kReadingsPerTerm * (kChains + n_later)) return std::nullopt;
  const auto epoch_of = [&m](int j) {
    return m.readings[static_cast<std::size_t>(j)].conditions.epoch;
  };
  std::vector<int> apart, within;  // epochs after the first: within the group those after its first
  bool is_first = !group.contains(m.first_epoch);
  for (const int epoch : m.later_epochs) {
    const bool later_of_group = group.contains(epoch) && !is_first;
    (later_of_group ? within : apart).push_back(epoch);
    if (group.contains(epoch)) is_first = false;
  }
  const Eigen::Index n_smooth = smooth.columns.cols();
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n_smooth + n_later);
  A.leftCols(n_smooth) = smooth.columns;
  Eigen::Index column = n_smooth;
  for (const int epoch : apart) {
    for (int j = 0; j < n; ++j) {
      const int its = epoch_of(j);
      A(j, column) = its == epoch || (group.contains(epoch) && group.contains(its)) ? 1 : 0;
    }
    ++column;
  }
  const Eigen::Index n_one = column;  // the group is one so far
  for (const int epoch : within) {
    for (int j = 0; j < n; ++j) A(j, column) = epoch_of(j) == epoch ? 1 : 0;
    ++column;
  }
  const Eigen::MatrixXd d = deviations(machine, m.readings);
  bool tested = false, step = false;
  for (int c = 0; c < 3; ++c) {
    if (!machine.machine().measured[static_cast<std::size_t>(c)]) continue;
    const Left none = left_by(A.leftCols(n_one), d.col(c));
    const Left steps = left_by(A, d.col(c));
    const int more = steps.rank - none.rank, freedom = n - steps.rank;
    if (more <= 0 || freedom <= 0) continue;
    tested = true;
    const double ratio = (none.sum_of_squares - steps.sum_of_squares) / more * freedom /
                         std::max(steps.sum_of_squares, 1e-300);
    if (ratio > variance_ratio_limit(level / 3, more, freedom)) step = true;
  }
  if (!tested) return std::nullopt;
  return step;
}

}  // namespace

EpochShift shift_of(const EpochShifts& shifts, int epoch) {
  const auto found = shifts.find(epoch);
  return found == shifts.end() ? EpochShift{} : found->second;
}

Pose in_frame(const Pose& frame, const Pose& pose) {
  const double c = std::cos(frame.phi_rad), s = std::sin(frame.phi_rad);
  return {c * pose.x_mm - s * pose.y_mm + frame.x_mm, s * pose.x_mm + c * pose.y_mm + frame.y_mm,
          pose.phi_rad + frame.phi_rad};
}

Pose out_of_frame(const Pose& frame, const Pose& pose) {
  const Pose moved{pose.x_mm - frame.x_mm, pose.y_mm - frame.y_mm, pose.phi_rad};
  return in_frame({0, 0, -frame.phi_rad}, moved);
}

EpochTest test_epochs(const NominalMachine& machine, std::span<const Reading> readings) {
  const Measured m = measured_of(readings);
  EpochTest test{.later_epochs = static_cast<int>(m.later_epochs.size())};
  if (test.later_epochs == 0) return test;
  std::set<int> all = m.later_epochs;
  all.insert(m.first_epoch);
  const std::optional<bool> steps = step_between(machine, m, all, test.level);
  test.tested = steps.has_value();
  test.hold = steps && !*steps;
  return test;
}

std::map<int, int> first_epochs(std::span<const std::pair<int, int>> held) {
  std::map<int, int> before;  // of an epoch one that it held with
  const auto first_of = [&before](int epoch) {
    while (before.contains(epoch)) epoch = before[epoch];
    return epoch;
  };
  for (const auto& [a, b] : held) {
    const auto [low, high] = std::minmax({first_of(a), first_of(b)});
    if (low != high) before[high] = low;
  }
  std::map<int, int> first;
  for (const auto& [epoch, any] : before) first[epoch] = first_of(any);
  return first;
}

void renumber(std::vector<Reading>& readings, const std::map<int, int>& first) {
  for (Reading& r : readings) {
    const auto at = first.find(r.conditions.epoch);
    if (at != first.end()) r.conditions.epoch = at->second;
  }
}

std::map<int, int> epochs_of_one_set_up(const NominalMachine& machine,
                                        std::span<const Reading> readings,
                                        std::span<const std::pair<int, int>> held) {
  std::map<int, std::set<int>> groups;  // by their first
  for (const auto& [epoch, first] : first_epochs(held)) groups[first].insert(epoch);
  const Measured m = measured_of(readings);
  std::map<int, int> of_one;
  for (auto& [one, epochs] : groups) {
    epochs.insert(one);
    if (step_between(machine, m, epochs, kFalseStepOfHeld).value_or(false)) continue;
    epochs.erase(one);
    for (const int epoch : epochs) of_one[epoch] = one;
  }
  return of_one;
}

EpochShifts epoch_shifts(const NominalMachine& machine, std::span<const Reading> readings) {
  const Measured m = measured_of(readings);
  if (m.later_epochs.empty()) return {};
  const Smooth smooth = smooth_of(m.readings);
  const Eigen::MatrixXd basis = orthonormal_basis(smooth.columns, kRankShare);
  const Eigen::MatrixXd d = deviations(machine, m.readings);
  const auto columns = shift_columns(machine, m);
  const Eigen::Index n = d.rows(), unknown = columns[0].cols();
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(unknown, unknown);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(unknown);
  for (Eigen::Index k = 0; k < unknown; ++k)
    normal(k, k) = 1 / (kPrior[k % kShift] * kPrior[k % kShift]);
  for (Eigen::Index c = 0; c < 3; ++c) {
    if (!machine.machine().measured[static_cast<std::size_t>(c)]) continue;
    const Eigen::MatrixXd& shifts = columns[static_cast<std::size_t>(c)];
    Eigen::MatrixXd all(n, smooth.columns.cols() + unknown);
    all << smooth.columns, shifts;
    const Left left = left_by(all, d.col(c));
    const auto freedom = std::max<Eigen::Index>(1, n - left.rank);
    const double weight = static_cast<double>(freedom) / std::max(left.sum_of_squares, 1e-300);
    const Eigen::MatrixXd A = shifts - basis * (basis.transpose() * shifts);
    normal += weight * (A.transpose() * A);
    right += weight * (A.transpose() * d.col(c));
  }
  const Eigen::VectorXd z = Cholesky(std::move(normal)).solve(right);
  EpochShifts found;
  Eigen::Index first = 0;
  for (const int epoch : m.later_epochs) {
    found[epoch] = {.l_zero_mm = z.segment<3>(first), .frame = Pose::from(z.segment<3>(first + 3))};
    first += kShift;
  }
  return found;
}

std::vector<Reading> without_shifts(std::span<const Reading> readings, const EpochShifts& shifts) {
  std::vector<Reading> all(readings.begin(), readings.end());
  for (Reading& r : all) {
    const EpochShift shift = shift_of(shifts, r.conditions.epoch);
    if (r.measured) r.measured = out_of_frame(shift.frame, *r.measured);
    r.conditions.cmd_mm += shift.l_zero_mm;
    r.conditions.from_mm += shift.l_zero_mm;
  }
  return all;
}

}  // namespace trammel
