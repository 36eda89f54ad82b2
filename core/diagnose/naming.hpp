#pragma once
// Which effects the model is missing: searched, fitted on the exact loop closures, and searched
// again there.

#include <algorithm>
#include <optional>
#include <vector>

#include "core/diagnose/average.hpp"
#include "core/diagnose/look_alikes.hpp"
#include "core/diagnose/selection.hpp"
#include "core/diagnose/work.hpp"

namespace trammel {

/// The best set, and what else was looked at, around its exact fit.
struct Naming {
  ResidualSpace space;  // around the fit, effects given back
  Library library;
  std::vector<Candidate> all;
  Candidate best;            // what earns its price
  Candidate fitted;          // with the rails that may stand for others
  std::vector<double> loss;  // of chi^2 on the exact model without each effect of `best`
  Average mean;              // under Prior::usual
  Average open;              // under Prior::open
  /// Of a reported value of a column of `library`, whichever of the priors holds.
  [[nodiscard]] double std_about(int column, double reported) const {
    return std::max(mean.std_about(column, reported), open.std_about(column, reported));
  }
  std::optional<Finding> unnamed;  // shape that does best in place of an effect
  double unnamed_score = 0;
  std::vector<LookAlike> alike;
};

/// Searches, fits the best set on the exact model, and searches again around that fit, until the
/// same set comes back. False when no set earns its price.
bool search_on_exact_model(Work& w, Naming& n);

/// What the exact fit loses without each effect; an effect whose loss does not pay its price goes,
/// the cheapest first. False when none is left.
bool drop_what_costs_nothing(Work& w, Naming& n);

/// The effects of the exact fit as they are reported: values, p of what the fit loses without each.
void name_effects(Work& w, const Naming& n);

}  // namespace trammel
