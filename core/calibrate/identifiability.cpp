#include "core/calibrate/identifiability.hpp"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "core/error.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

constexpr double kMember = 0.01;  // of a tolerance: smaller shares are not worth naming
constexpr double kByItself =
    0.05;  // of a tolerance may leak into the null space of an identified one

/// R of A = QR when A is tall: the same singular values and directions, from n x n.
Eigen::MatrixXd compact(const Eigen::MatrixXd& A) {
  if (A.rows() <= A.cols()) return A;
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(A);
  return qr.matrixQR().topRows(A.cols()).triangularView<Eigen::Upper>();
}

int count_above(const Eigen::VectorXd& s, double least) {
  return static_cast<int>((s.array() > least).count());
}

Observability observability_of(const Eigen::VectorXd& s, int rank, int n_poses) {
  if (rank == 0) return {};
  const Eigen::ArrayXd kept = s.head(rank).array();
  const double first = kept[0], last = kept[rank - 1];
  return {.O1 = std::exp(kept.log().mean()) / std::sqrt(static_cast<double>(n_poses)),
          .O2 = last / first,
          .O3 = last,
          .O4 = last * last / first,
          .O5 = 1 / kept.inverse().sum()};
}

/// Reduced echelon form of the rows: each pivot column keeps one entry. Columns that parameters
/// named "R" and "S" own are taken first, so that the known ties (l with R) come out as pairs.
void reduce(Eigen::MatrixXd& rows, const std::vector<int>& preference) {
  Eigen::Index row = 0;
  for (const int column : preference) {
    if (row == rows.rows()) return;
    Eigen::Index at = 0;
    const double largest = rows.col(column).tail(rows.rows() - row).cwiseAbs().maxCoeff(&at);
    if (largest < 0.05) continue;  // of a unit vector: too weak to divide by
    rows.row(row).swap(rows.row(row + at));
    rows.row(row) /= rows(row, column);
    for (Eigen::Index other = 0; other < rows.rows(); ++other) {
      if (other != row) rows.row(other) -= rows(other, column) * rows.row(row);
    }
    ++row;
  }
}

std::vector<int> preference(const std::vector<ScaledParameter>& parameters) {
  std::vector<int> order;
  for (const char letter : {'R', 'h', 'S', 'f', 'z', 'r', 'b', 'a', 'l'}) {
    for (std::size_t k = 0; k < parameters.size(); ++k) {
      if (parameters[k].name[0] == letter) order.push_back(static_cast<int>(k));
    }
  }
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const int column = static_cast<int>(k);
    if (std::find(order.begin(), order.end(), column) == order.end()) order.push_back(column);
  }
  return order;
}

std::string amount(const ScaledParameter& parameter, double value) {
  char text[120];
  if (!parameter.unit.empty()) {
    std::snprintf(text, sizeof text, "%s by %+.3g %s", parameter.name.c_str(), value,
                  parameter.unit.c_str());
    return text;
  }
  std::snprintf(text, sizeof text, "%s by %+.4f %s", parameter.name.c_str(),
                parameter.is_angle ? deg_from_rad(value) : value,
                parameter.is_angle ? "deg" : "mm");
  return text;
}

std::string pair_sentence(const ScaledParameter& a, const ScaledParameter& b, double ratio) {
  const std::string sign = ratio > 0 ? " - " : " + ";
  if (std::abs(std::abs(ratio) - 1) < 0.01 && a.is_angle == b.is_angle) {
    return a.name + " and " + b.name + " act as one: readings know only " + a.name + sign + b.name;
  }
  char factor[60];
  std::snprintf(factor, sizeof factor, "%.4g", std::abs(ratio));
  return a.name + " and " + b.name + " act as one: readings know only " + a.name + sign + factor +
         " " + b.name + (a.is_angle == b.is_angle ? "" : " (mm and rad)");
}

NullDirection describe(const Eigen::VectorXd& in_tolerances,
                       const std::vector<ScaledParameter>& parameters) {
  NullDirection direction;
  const Eigen::VectorXd v = in_tolerances / in_tolerances.cwiseAbs().maxCoeff();
  direction.change = v;
  for (Eigen::Index k = 0; k < v.size(); ++k) {
    const auto& parameter = parameters[static_cast<std::size_t>(k)];
    direction.change[k] *= parameter.tolerance;
    if (std::abs(v[k]) > kMember) direction.members.push_back(static_cast<int>(k));
  }
  const auto at = [&](std::size_t m) -> const ScaledParameter& {
    return parameters[static_cast<std::size_t>(direction.members[m])];
  };
  const auto& c = direction.change;
  if (direction.members.size() == 1) {
    direction.sentence = at(0).name + " is not identified: no reading depends on it";
  } else if (direction.members.size() == 2) {
    direction.sentence =
        pair_sentence(at(0), at(1), c[direction.members[0]] / c[direction.members[1]]);
  } else {
    for (std::size_t m = 0; m < direction.members.size(); ++m) {
      direction.sentence += (m == 0 ? "" : ", ") + amount(at(m), c[direction.members[m]]);
    }
    direction.sentence =
        "no reading feels this change, so it is not identified: " + direction.sentence +
        " together";
  }
  return direction;
}

}  // namespace

Identifiability identifiability(const Eigen::MatrixXd& A,
                                const std::vector<ScaledParameter>& parameters) {
  const Eigen::Index n = A.cols();
  TRAMMEL_ASSERT(static_cast<std::size_t>(n) == parameters.size() && n > 0);
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(compact(A), Eigen::ComputeFullV);
  Identifiability result;
  result.n_poses = static_cast<int>(A.rows() / 3);
  result.singular = Eigen::VectorXd::Zero(n);
  result.singular.head(svd.singularValues().size()) = svd.singularValues();
  const double rounding = static_cast<double>(std::max(A.rows(), n)) *
                          std::numeric_limits<double>::epsilon() * result.singular[0];
  result.rank_machine = count_above(result.singular, rounding);
  result.rank = std::min(count_above(result.singular, kLeastSignal), result.rank_machine);
  result.directions = svd.matrixV();
  result.observability = observability_of(result.singular, result.rank, result.n_poses);

  const Eigen::MatrixXd null = result.directions.rightCols(n - result.rank);
  for (Eigen::Index k = 0; k < n; ++k) {
    result.identified.push_back(null.row(k).norm() < kByItself);
  }
  Eigen::MatrixXd rows = null.transpose();
  reduce(rows, preference(parameters));
  for (Eigen::Index r = 0; r < rows.rows(); ++r) {
    result.null_space.push_back(describe(rows.row(r).transpose(), parameters));
  }
  return result;
}

Eigen::MatrixXd covariance(const Identifiability& of,
                           const std::vector<ScaledParameter>& parameters) {
  const Eigen::MatrixXd V = of.directions.leftCols(of.rank);
  Eigen::MatrixXd half = V * of.singular.head(of.rank).cwiseInverse().asDiagonal();
  for (Eigen::Index k = 0; k < half.rows(); ++k) {
    half.row(k) *= parameters[static_cast<std::size_t>(k)].tolerance;
  }
  return half * half.transpose();
}

std::vector<std::string> in_words(const Identifiability& of,
                                  const std::vector<ScaledParameter>& parameters) {
  const auto n = static_cast<int>(parameters.size());
  std::vector<std::string> words;
  char text[400];
  std::snprintf(text, sizeof text,
                "rank %d of %d: %d combinations of the %d parameters are identified, %d are not",
                of.rank, n, of.rank, n, n - of.rank);
  words.emplace_back(text);
  if (of.rank_machine > of.rank) {
    std::snprintf(
        text, sizeof text,
        "%d more singular values are not zero, but carry nothing: along these directions the "
        "noise leaves more than %.0f tolerances",
        of.rank_machine - of.rank, 1 / kLeastSignal);
    words.emplace_back(text);
  }
  for (const NullDirection& direction : of.null_space) words.push_back(direction.sentence);
  return words;
}

}  // namespace trammel
