#include "core/diagnose/average.hpp"

#include <algorithm>
#include <cmath>

namespace trammel {

std::optional<int> column_of(const Library& library, int effect, int parameter) {
  for (const Unit& unit : library.units) {
    if (unit.effect != effect || unit.common) continue;
    for (std::size_t i = 0; i < unit.parameters.size(); ++i) {
      if (unit.parameters[i] == parameter) return unit.columns[i];
    }
  }
  return std::nullopt;
}

double Average::std_about(int column, double reported) const {
  const auto about = [&](double v, double v2) {
    return v2 - 2 * v * reported + reported * reported;
  };
  const double all = std::max(0.0, about(value[column], square[column]));
  double most = all;
  for (std::size_t e = 0; e < probability.size(); ++e) {
    const double p = probability[e];
    if (p < kNotRuledOut || p >= kHeldIn) continue;
    const auto row = static_cast<Eigen::Index>(e);
    const double with = about(value_with(row, column), square_with(row, column));
    most = std::max(most, kHeldIn * with + (1 - kHeldIn) * (all - p * with) / (1 - p));
  }
  return std::sqrt(most);
}

Average average(const Library& library, const std::vector<Candidate>& family,
                double Candidate::*of) {
  Average mean;
  mean.probability.assign(effect_catalogue().size(), 0);
  mean.presence = mean.value = mean.square = Eigen::VectorXd::Zero(library.gram.cols());
  mean.value_with = mean.square_with =
      Eigen::MatrixXd::Zero(std::ssize(mean.probability), library.gram.cols());
  double total = 0;
  const double highest = family.empty() ? 0 : (*std::ranges::max_element(family, {}, of)).*of;
  for (const Candidate& c : family) {
    const double weight = std::exp(0.5 * (c.*of - highest));
    total += weight;
    for (const int e : c.effects) mean.probability[static_cast<std::size_t>(e)] += weight;
    Eigen::Index first = 0;
    for (const int u : c.units) {
      const Unit& unit = library.units[static_cast<std::size_t>(u)];
      for (std::size_t i = 0; i < unit.parameters.size(); ++i) {
        const auto at = first + static_cast<Eigen::Index>(unit.column_at(i));
        const int column = *column_of(library, unit.effect, unit.parameters[i]);
        mean.presence[column] += weight;
        const double v = weight * c.values[at];
        const double v2 = weight * (c.values[at] * c.values[at] + c.std[at] * c.std[at]);
        mean.value[column] += v;
        mean.square[column] += v2;
        for (const int e : c.effects) {
          mean.value_with(e, column) += v;
          mean.square_with(e, column) += v2;
        }
      }
      first += static_cast<Eigen::Index>(unit.columns.size());
    }
  }
  for (std::size_t e = 0; e < mean.probability.size(); ++e) {
    const auto row = static_cast<Eigen::Index>(e);
    const double of_effect = std::max(mean.probability[e], 1e-300);
    mean.value_with.row(row) /= of_effect;
    mean.square_with.row(row) /= of_effect;
    mean.probability[e] /= total;
  }
  mean.presence /= total;
  mean.value /= total;
  mean.square /= total;
  return mean;
}

}  // namespace trammel
