#include "core/calibrate/identifiability.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "core/error.hpp"
#include "core/linear/products.hpp"
#include "core/linear/singular_values.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

constexpr double kMember = 0.05;  // of a tolerance: smaller shares are not worth naming
constexpr double kByItself =
    0.05;  // of a tolerance may leak into the null space of an identified one

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

/// Reduced echelon form of the rows: each pivot column keeps one entry; returns the pivots. Columns
/// that parameters named "R" and "S" own are taken first, so that the known ties (l with R) come
/// out as pairs.
std::vector<int> reduce(Eigen::MatrixXd& rows, const std::vector<int>& preference) {
  std::vector<int> pivots;
  const auto take = [&](int column, double least) {
    const auto row = static_cast<Eigen::Index>(pivots.size());
    if (row == rows.rows()) return;
    Eigen::Index at = 0;
    const double largest = rows.col(column).tail(rows.rows() - row).cwiseAbs().maxCoeff(&at);
    if (largest < least) return;
    rows.row(row).swap(rows.row(row + at));
    rows.row(row) /= rows(row, column);
    for (Eigen::Index other = 0; other < rows.rows(); ++other) {
      if (other != row) rows.row(other) -= rows(other, column) * rows.row(row);
    }
    pivots.push_back(column);
  };
  for (const int column : preference) take(column, 0.05);  // of a unit vector: weaker divides badly
  while (static_cast<Eigen::Index>(pivots.size()) < rows.rows()) {  // what is left, at its largest
    Eigen::Index row = 0, column = 0;
    rows.bottomRows(rows.rows() - static_cast<Eigen::Index>(pivots.size()))
        .cwiseAbs()
        .maxCoeff(&row, &column);
    take(static_cast<int>(column), 0);
  }
  return pivots;
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

std::string unit_of(const ScaledParameter& p) {
  return !p.unit.empty() ? p.unit : p.is_angle ? "deg" : "mm";
}
double shown(const ScaledParameter& p, double value) {
  return p.is_angle ? deg_from_rad(value) : value;
}

/// " mm"; nothing for what has no unit.
std::string after_number(const std::string& unit) { return unit == "1" ? "" : " " + unit; }

std::string amount(const ScaledParameter& parameter, double value) {
  char text[160];
  std::snprintf(text, sizeof text, parameter.unit.empty() ? "%s by %+.4f%s" : "%s by %+.3g%s",
                parameter.name.c_str(), shown(parameter, value),
                after_number(unit_of(parameter)).c_str());
  return text;
}

/// " - R_1", " + 1.15 deg/mm r_1": a coefficient of the leading parameter's unit over the other's.
std::string term(const ScaledParameter& leader, const ScaledParameter& other, double coefficient) {
  const double c = shown(leader, coefficient) / shown(other, 1);
  const std::string sign = c < 0 ? " - " : " + ";
  if (unit_of(leader) == unit_of(other) && std::abs(std::abs(c) - 1) < 0.01) {
    return sign + other.name;
  }
  char text[160];
  if (unit_of(leader) == unit_of(other)) {
    std::snprintf(text, sizeof text, "%.3g %s", std::abs(c), other.name.c_str());
  } else {
    std::snprintf(text, sizeof text, "%.3g %s/%s %s", std::abs(c), unit_of(leader).c_str(),
                  unit_of(other).c_str(), other.name.c_str());
  }
  return sign + text;
}

/// "0.4494 +- 0.1835 mm (k = 2)", or without a value "+- 0.1835 mm (k = 2)".
std::string amount(const IdentifiedCombination& c) {
  const double unit = c.is_angle ? deg_from_rad(1) : 1;
  const bool plain = c.unit == "deg" || c.unit == "mm";
  char text[120], value[40] = "";
  const double U = 2 * unit * c.standard_uncertainty;
  const int decimals = U < 0.001 ? 6 : 4;  // as identified_table: zeros say nothing
  if (c.value && plain) std::snprintf(value, sizeof value, "%.*f ", decimals, unit * *c.value);
  if (c.value && !plain) std::snprintf(value, sizeof value, "%.4g ", unit * *c.value);
  if (plain) {
    std::snprintf(text, sizeof text, "%s+- %.*f%s (k = 2)", value, decimals, U,
                  after_number(c.unit).c_str());
  } else {
    std::snprintf(text, sizeof text, "%s+- %.2g%s (k = 2)", value, U, after_number(c.unit).c_str());
  }
  return text;
}

std::string pair_sentence(const ScaledParameter& a, const ScaledParameter& b, double ratio) {
  return a.name + " and " + b.name + " act as one: readings know only " + a.name +
         term(a, b, -ratio);
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
  return identifiability(A, parameters, static_cast<int>(A.rows() / 3));
}

Identifiability identifiability(const Eigen::MatrixXd& A,
                                const std::vector<ScaledParameter>& parameters, int n_poses) {
  const Eigen::Index n = A.cols();
  TRAMMEL_ASSERT(static_cast<std::size_t>(n) == parameters.size() && n > 0);
  SingularValues svd = singular_values(A);
  Identifiability result;
  result.n_poses = n_poses;
  result.singular = std::move(svd.singular);
  const double rounding = static_cast<double>(std::max<Eigen::Index>(3 * n_poses, n)) *
                          std::numeric_limits<double>::epsilon() * result.singular[0];
  result.rank_machine = count_above(result.singular, rounding);
  result.rank = std::min(count_above(result.singular, kLeastSignal), result.rank_machine);
  result.directions = std::move(svd.V);
  result.observability = observability_of(result.singular, result.rank, result.n_poses);

  const Eigen::MatrixXd null = result.directions.rightCols(n - result.rank);
  for (Eigen::Index k = 0; k < n; ++k) {
    result.identified.push_back(null.row(k).norm() < kByItself);
  }
  Eigen::MatrixXd rows = null.transpose();
  const std::vector<int> pivots = reduce(rows, preference(parameters));
  for (Eigen::Index r = 0; r < rows.rows(); ++r) {
    result.null_space.push_back(describe(rows.row(r).transpose(), parameters));
    result.null_space.back().pivot = pivots[static_cast<std::size_t>(r)];
  }
  return result;
}

Eigen::MatrixXd covariance(const Identifiability& of,
                           const std::vector<ScaledParameter>& parameters) {
  Eigen::MatrixXd half = of.directions.leftCols(of.rank);
  for (Eigen::Index k = 0; k < half.cols(); ++k) half.col(k) *= 1 / of.singular[k];
  for (Eigen::Index k = 0; k < half.rows(); ++k) {
    half.row(k) *= parameters[static_cast<std::size_t>(k)].tolerance;
  }
  return product_transposed(half, half);
}

std::vector<IdentifiedCombination> identified_combinations(
    const Identifiability& of, const std::vector<ScaledParameter>& parameters,
    const Eigen::MatrixXd& covariance, const Eigen::VectorXd& values) {
  const auto n = static_cast<Eigen::Index>(parameters.size());
  std::vector<bool> given_up(parameters.size(), false);
  for (const NullDirection& d : of.null_space) given_up[static_cast<std::size_t>(d.pivot)] = true;
  std::vector<IdentifiedCombination> all;
  for (Eigen::Index j = 0; j < n; ++j) {
    const ScaledParameter& leader = parameters[static_cast<std::size_t>(j)];
    if (given_up[static_cast<std::size_t>(j)]) continue;
    IdentifiedCombination c{.name = leader.name,
                            .unit = unit_of(leader),
                            .is_angle = leader.is_angle,
                            .alone = of.identified[static_cast<std::size_t>(j)],
                            .members = {static_cast<int>(j)},
                            .of = Eigen::VectorXd::Unit(n, j),
                            .value = {}};
    for (const NullDirection& d : of.null_space) {
      const double coefficient = -d.change[j] / d.change[d.pivot];
      c.of[d.pivot] = coefficient;
      const ScaledParameter& other = parameters[static_cast<std::size_t>(d.pivot)];
      if (c.alone || std::abs(coefficient) * other.tolerance < kMember * leader.tolerance) continue;
      c.name += term(leader, other, coefficient);
      c.members.push_back(d.pivot);
    }
    if (values.size() == n) c.value = c.of.dot(values);
    c.standard_uncertainty = std::sqrt(std::max(0.0, c.of.dot(times(covariance, c.of))));
    all.push_back(std::move(c));
  }
  return all;
}

std::vector<Correlation> strong_correlations(const std::vector<IdentifiedCombination>& of,
                                             const Eigen::MatrixXd& covariance) {
  std::vector<Correlation> strong;
  for (std::size_t a = 0; a < of.size(); ++a) {
    const Eigen::VectorXd with = times(covariance, of[a].of);
    for (std::size_t b = a + 1; b < of.size(); ++b) {
      const double size = of[a].standard_uncertainty * of[b].standard_uncertainty;
      const double r = size > 0 ? with.dot(of[b].of) / size : 0;
      if (std::abs(r) < kStrongCorrelation) continue;
      strong.push_back({static_cast<int>(a), static_cast<int>(b), std::clamp(r, -1.0, 1.0)});
    }
  }
  std::stable_sort(strong.begin(), strong.end(), [](const Correlation& x, const Correlation& y) {
    return std::abs(x.r) > std::abs(y.r);
  });
  return strong;
}

namespace {

/// "strongly correlated: S_1 with S_2 (-0.98), … and 3 more pairs"; empty when nothing is.
std::string correlation_words(const std::vector<IdentifiedCombination>& known,
                              const std::vector<Correlation>& correlated) {
  constexpr std::size_t kTold = 3;
  std::string sentence;
  for (std::size_t k = 0; k < std::min(kTold, correlated.size()); ++k) {
    char r[20];
    std::snprintf(r, sizeof r, " (%+.3f)", correlated[k].r);
    sentence += (k == 0 ? "strongly correlated, so known together better than one by one: " : ", ");
    sentence += known[static_cast<std::size_t>(correlated[k].a)].name + " with " +
                known[static_cast<std::size_t>(correlated[k].b)].name + r;
  }
  if (correlated.size() > kTold) {
    sentence += " and " + std::to_string(correlated.size() - kTold) + " more pairs";
  }
  return sentence;
}

}  // namespace

std::vector<std::string> in_words(const Identifiability& of,
                                  const std::vector<ScaledParameter>& parameters,
                                  const std::vector<IdentifiedCombination>& known,
                                  const std::vector<Correlation>& correlated) {
  const auto n = static_cast<int>(parameters.size());
  std::vector<std::string> words;
  char text[400];
  std::snprintf(text, sizeof text,
                "rank %d of %d: %d combination%s of the %d parameters %s identified, %d %s not",
                of.rank, n, of.rank, of.rank == 1 ? "" : "s", n, of.rank == 1 ? "is" : "are",
                n - of.rank, n - of.rank == 1 ? "is" : "are");
  words.emplace_back(text);
  if (of.rank_machine > of.rank) {
    std::snprintf(
        text, sizeof text,
        "%d more singular values are not zero, but carry nothing: along these directions the "
        "noise leaves more than %.0f tolerances",
        of.rank_machine - of.rank, 1 / kLeastSignal);
    words.emplace_back(text);
  }
  std::vector<bool> told(known.size(), false);
  for (const NullDirection& direction : of.null_space) {
    words.push_back(direction.sentence);
    bool known_alone = false;
    for (std::size_t k = 0; k < known.size(); ++k) {  // of a pair that nothing else touches
      std::vector<int> members = known[k].members;
      std::sort(members.begin(), members.end());
      if (direction.members.size() != 2 || members != direction.members) continue;
      words.back() += (known[k].value ? " = " : ", ") + amount(known[k]);
      told[k] = known_alone = true;
    }
    if (direction.members.size() == 2 && !known_alone) {
      words.back() += ", and that only together with others";
    }
  }
  for (std::size_t k = 0; k < known.size(); ++k) {
    if (known[k].alone || told[k]) continue;
    words.push_back("identified of these: " + known[k].name + (known[k].value ? " = " : ", ") +
                    amount(known[k]));
  }
  if (!correlated.empty()) words.push_back(correlation_words(known, correlated));
  return words;
}

}  // namespace trammel
