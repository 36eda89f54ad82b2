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
  const double about = square[column] - 2 * value[column] * reported + reported * reported;
  return std::sqrt(std::max(0.0, about));
}

Average average(const Library& library, const std::vector<Candidate>& family,
                double Candidate::*of) {
  Average mean;
  mean.probability.assign(effect_catalogue().size(), 0);
  mean.presence = mean.value = mean.square = Eigen::VectorXd::Zero(library.gram.cols());
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
        mean.value[column] += weight * c.values[at];
        mean.square[column] += weight * (c.values[at] * c.values[at] + c.std[at] * c.std[at]);
      }
      first += static_cast<Eigen::Index>(unit.columns.size());
    }
  }
  for (double& p : mean.probability) p /= total;
  mean.presence /= total;
  mean.value /= total;
  mean.square /= total;
  return mean;
}

}  // namespace trammel
