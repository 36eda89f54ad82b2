#include "core/calibrate/drive_table.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/error.hpp"
#include "core/linear/decompositions.hpp"

namespace trammel {

namespace {

constexpr double kStraight = 1e-6;  // weight of the second differences, of the samples at a knot

/// Knot below the position, and how far it is to the next.
struct Between {
  std::size_t knot = 0;
  double share = 0;
};
Between between(const DriveTable& table, double position_mm) {
  const auto last = static_cast<double>(table.values_mm.size() - 1);
  const double at = std::clamp((position_mm - table.first_mm) / table.step_mm, 0.0, last);
  const double knot = std::min(std::floor(at), last - 1);
  return {static_cast<std::size_t>(knot), at - knot};
}

[[noreturn]] void refuse_table(const std::string& got, const std::string& expected) {
  throw InputError({.what = "no table of a drive can be made",
                    .where = {.field = "--step-mm"},
                    .got = got,
                    .expected = expected});
}

}  // namespace

double DriveTable::at(double position_mm) const {
  const Between b = between(*this, position_mm);
  return (1 - b.share) * values_mm[b.knot] + b.share * values_mm[b.knot + 1];
}

DriveTable fit_drive_table(std::span<const DriveSample> samples, double step_mm,
                           std::size_t most_knots) {
  if (samples.empty()) refuse_table("no targets within reach", "one or more");
  if (!(step_mm > 0)) refuse_table(std::to_string(step_mm), "mm, above 0");
  const auto [low, high] =
      std::ranges::minmax_element(samples, {}, [](const DriveSample& s) { return s.position_mm; });
  const double first = std::floor(low->position_mm / step_mm);
  const double knots = std::max(std::ceil(high->position_mm / step_mm) - first + 1, 2.0);
  if (knots > static_cast<double>(most_knots)) {
    refuse_table(std::to_string(static_cast<long>(knots)) + " knots",
                 "a wider step: at most " + std::to_string(most_knots) + " knots");
  }
  const auto n = static_cast<Eigen::Index>(knots);
  DriveTable table{first * step_mm, step_mm, std::vector<double>(static_cast<std::size_t>(n))};
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
  for (const DriveSample& s : samples) {
    const Between p = between(table, s.position_mm);
    const auto k = static_cast<Eigen::Index>(p.knot);
    const Eigen::Vector2d hat(1 - p.share, p.share);
    A.block<2, 2>(k, k) += hat * hat.transpose();
    b.segment<2>(k) += s.correction_mm * hat;
  }
  const double w = kStraight * static_cast<double>(samples.size()) / knots;
  const Eigen::Vector3d bend(1, -2, 1);
  for (Eigen::Index k = 0; k + 2 < n; ++k) A.block<3, 3>(k, k) += w * bend * bend.transpose();
  A.diagonal().array() += 1e-9 * w;  // positions that are all one leave a slope free
  const Eigen::VectorXd values = Cholesky(A).solve(b);
  for (Eigen::Index k = 0; k < n; ++k) table.values_mm[static_cast<std::size_t>(k)] = values[k];
  return table;
}

TableError error_left(std::span<const DriveSample> samples, const DriveTable& table) {
  TableError left;
  for (const DriveSample& s : samples) {
    const double error_mm = std::abs(s.correction_mm - table.at(s.position_mm));
    left.rms_mm += error_mm * error_mm / static_cast<double>(samples.size());
    left.max_mm = std::max(left.max_mm, error_mm);
  }
  left.rms_mm = std::sqrt(left.rms_mm);
  return left;
}

}  // namespace trammel
