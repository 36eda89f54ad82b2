#pragma once
// What is known of each effect and value when the choice of the set is not certain.

#include <optional>
#include <vector>

#include "core/diagnose/selection.hpp"

namespace trammel {

/// Averages over a family of sets, each weighted by exp(weight / 2) (Hoeting et al. 1999, Bayesian
/// model averaging, eqs. 1 to 4). The weight is the gain less the cheaper of two prices: that of
/// the search (rails of one size, an effect one in 850), or the marginal likelihood's own with the
/// usual ranges as priors (MacKay 1992), ln det(I + U G U) + kPriceOfPresence for each name: a
/// mixture of both priors. The second is low where effects are nearly the same data, and there a
/// value hangs most on which of them were left out: the search's price alone, made to keep false
/// names rare, would state it too certain.
///
/// Standard deviations are the larger of that average's and of one by open_weight, since the
/// former's prior is chosen to name little: where two effects nearly cancel what a third can say,
/// the true set of two costs 17 more than the third and gains 4, and one in 700 is no account of
/// it. They hold for every prior in between (robust Bayes, Berger 1990).
struct Average {
  std::vector<double> probability;  // of each effect of the catalogue: weight of the sets with it
  Eigen::VectorXd presence;         // the same of each column of single units
  Eigen::VectorXd value, square;    // E v and E v^2 of each column of single units; 0 where absent
  /// Root mean square distance of the truth from `reported`: choice of the set and noise together.
  [[nodiscard]] double std_about(int column, double reported) const;
};
Average average(const Library& library, const std::vector<Candidate>& family,
                double Candidate::*weight = &Candidate::weight);

/// The column of one parameter by itself; nothing when these readings can't show it.
std::optional<int> column_of(const Library& library, int effect, int parameter);

}  // namespace trammel
