#include "core/diagnose/unnamed.hpp"

#include <algorithm>

namespace trammel {

namespace {

/// What each pair of effects of the catalogue can say together, on all their rails: orthonormal.
std::vector<Eigen::MatrixXd> spans_of_pairs(const ResidualSpace& space, const Library& library) {
  std::vector<Eigen::MatrixXd> spans;
  const Eigen::MatrixXd projected = space.project(library.signals);
  const auto columns_of = [&](int a, int b) {
    std::vector<int> columns;
    for (const Unit& unit : library.units) {
      if (unit.effect != a && unit.effect != b) continue;
      columns.insert(columns.end(), unit.columns.begin(), unit.columns.end());
    }
    return columns;
  };
  const int effects = static_cast<int>(effect_catalogue().size());
  for (int a = 0; a < effects; ++a) {
    for (int b = a + 1; b < effects; ++b) {
      const std::vector<int> columns = columns_of(a, b);
      if (!columns.empty()) spans.push_back(orthonormal(projected(Eigen::all, columns)));
    }
  }
  return spans;
}

}  // namespace

std::optional<Finding> best_unnamed(const ResidualSpace& space, const Library& library,
                                    const Candidate& best, const std::vector<Shape>& shapes,
                                    double& score) {
  constexpr double kSameShape = 0.95;  // share of a signal that makes it the same one
  std::vector<std::vector<int>> kept = {{}};
  if (best.effects.size() > 1) {
    for (const int effect : best.effects) {
      kept.emplace_back();
      for (const int u : best.units) {
        if (library.units[static_cast<std::size_t>(u)].effect != effect) kept.back().push_back(u);
      }
    }
  }
  std::vector<int> columns;
  for (const int u : best.units) {
    const auto& unit = library.units[static_cast<std::size_t>(u)];
    columns.insert(columns.end(), unit.columns.begin(), unit.columns.end());
  }
  Eigen::VectorXd fitted = Eigen::VectorXd::Zero(space.rows());
  for (std::size_t i = 0; i < columns.size(); ++i) {
    fitted += best.values[static_cast<Eigen::Index>(i)] * library.signals.col(columns[i]);
  }
  fitted = space.project(fitted);
  const double search_price =
      kPriceOfName + 2 * std::log(static_cast<double>(shapes.size()) / 30.0);
  const std::vector<Eigen::MatrixXd> named = spans_of_pairs(space, library);
  std::optional<Finding> found;
  for (const auto& units : kept) {
    Eigen::MatrixXd known(space.rows(), parameter_count(library, units));
    Eigen::Index at = 0;
    for (const int u : units) {
      for (const int c : library.units[static_cast<std::size_t>(u)].columns)
        known.col(at++) = library.signals.col(c);
    }
    const Eigen::MatrixXd K = orthonormal(space.project(known));
    const Eigen::VectorXd r = without(K, space.residual);
    const Eigen::VectorXd replaced = without(K, fitted);
    const double base = gain_of(library, units) - price_of(library, units);
    for (const Shape& shape : shapes) {
      if (shape.where.starts_with("effect ")) continue;
      Eigen::MatrixXd D = space.project(shape.columns);
      if (D.norm() < 1e-6 * shape.columns.norm()) continue;
      D = without(K, D);
      const Eigen::MatrixXd U = orthonormal(D);
      const Eigen::VectorXd coefficients = transposed_times(U, r);
      const double gain = coefficients.squaredNorm();
      const double s =
          base + gain - search_price - kPriceOfParameter * static_cast<double>(U.cols());
      if (found && s <= score) continue;  // first what is cheap to ask
      if (transposed_times(U, replaced).squaredNorm() > kSameShape * replaced.squaredNorm())
        continue;
      const Eigen::VectorXd seen = times(U, coefficients);
      if (std::any_of(named.begin(), named.end(), [&](const Eigen::MatrixXd& pair) {
            return transposed_times(pair, seen).squaredNorm() > kSameShape * seen.squaredNorm();
          })) {
        continue;
      }
      score = s;
      found = Finding{shape.where, shape.when, chi2_tail(gain, static_cast<double>(U.cols())), gain,
                      static_cast<int>(U.cols())};
    }
  }
  return found;
}

}  // namespace trammel
