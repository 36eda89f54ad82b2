#pragma once
// Which sets of effects explain the residuals, jointly with a refit of the base.

#include <optional>
#include <string>
#include <vector>

#include "core/diagnose/residual_space.hpp"
#include "core/diagnose/structure.hpp"
#include "core/model/effect.hpp"

namespace trammel {

/// The part of an effect that is in or out as a whole: one parameter, or those that are joined (a
/// wave's sine and cosine, a force's components).
struct Unit {
  int effect = 0;               // place in the catalogue
  std::vector<int> parameters;  // of the effect
  std::vector<int> columns;     // of Library::signals: one a parameter, or one for all (common)
  bool common = false;          // the same value on every rail: one column, one price
  /// Place in `columns` of the i-th parameter.
  [[nodiscard]] std::size_t column_at(std::size_t i) const { return common ? 0 : i; }
};

/// Every effect the readings have the conditions for, as columns.
struct Library {
  std::vector<Unit> units;
  std::vector<ActiveEffect> remembered;  // shapes of the effects with a memory that take part
  Eigen::MatrixXd signals;    // whitened, per unit of parameter, not projected, shape (3N, columns)
  Eigen::VectorXd usual_max;  // of each column's parameter
  Eigen::VectorXd usual_min;
  Eigen::MatrixXd gram;    // signals' M signals
  Eigen::VectorXd moment;  // signals' M r
};
Library make_library(const ResidualSpace& space);

/// A set of effects with the rails they act on, and what it earns.
struct Candidate {
  std::vector<int> effects;  // places in the catalogue, rising
  std::vector<int> units;    // places in Library::units
  Eigen::VectorXd values;    // of the columns, in the order of the units
  Eigen::VectorXd std;
  int parameters = 0;
  double gain = 0;    // fall of chi^2 against the base alone, less what the ranges cost
  double score = 0;   // gain less the price of the library searched
  double occam = 0;   // ln det(I + U G U), U the usual ranges: what the width of the priors costs
  bool usual = true;  // every value has a sign that its effect can have
  /// Twice the log of the set's weight in an average, up to a constant: where effects are few and
  /// of usual size; and where any is as likely in as out, and no larger by itself than all that is
  /// missing (of a family only).
  double weight = 0, open_weight = 0;
};

// The price, in chi^2: an effect that is not there adds its name by chance in less than 1 % of
// campaigns (31 units of 1 or 2 terms). Further units (rails) of a named effect are cheaper, by the
// number there is to choose from: what is on one rail is often on the others, and a small effect on
// three must not be named as another that needs one parameter. Measured: README.md.
inline constexpr double kPriceOfName = 8.0;
inline constexpr double kPriceOfParameter = 5.5;
inline constexpr double kPriceOfFurther = 1.5;  // a parameter of a further unit, and 2 ln(units)
inline constexpr double kPriceOfShape = kPriceOfParameter;  // of a memory, fitted or chosen
inline constexpr double kPriceOfImpossible = 12.0;          // of a sign that the effect can't have
inline constexpr double kEvidence20To1 = 6.0;               // 2 ln 20

/// Least squares of some units, jointly with the base; nothing when they are collinear. A usual
/// range is a prior without a cliff, v ~ N(0, usual_max^2): a set maximises
///   -chi^2 - sum (v / usual_max)^2,   gain = m' (G + diag(usual_max)^-2)^-1 m
/// so a value of twice the range costs 4 of chi^2, not the effect, and one that the readings do not
/// know costs nothing.
std::optional<Candidate> solve(const Library& library, const std::vector<int>& units);

/// For every set of up to `most` effects, its best choice of units, by falling score. With
/// `most_parameters` > 0 only choices of at most as many parameters.
std::vector<Candidate> search(const Library& library, int most, int most_parameters = 0);

/// The sets that explain the readings as well as `best`: other names, no superset, possible signs,
/// evidence within 20:1. More parameters than `best` are allowed: each has paid its price, and a
/// small effect on three rails is easily mistaken for another with one parameter.
std::vector<Candidate> rivals_of(const Candidate& best, const std::vector<Candidate>& all);

/// `best` with further effects, while each earns its price (search() ends at three).
Candidate extend(const Library& library, Candidate best);

/// `best` with those further units (rails) of its own effects that may stand for one it has, in 2 %
/// of campaigns: a value is never stated more certain than the choice of its rail.
inline constexpr double kStandsFor = 7.8;  // 2 ln 49
Candidate with_all_rails(const Library& library, const Candidate& best);

/// Every choice of units, of sets within `kFamily` of the best of `all` and of `best` with one
/// effect more, that weighs within it under either prior: what an average is taken over.
std::vector<Candidate> family_of(const Library& library, const Candidate& best,
                                 const std::vector<Candidate>& all);
/// Of a set of more effects (noise far below what is missing lets many in) the rails stay as
/// chosen.
inline constexpr std::size_t kMostSearched = 3;
inline constexpr double kFamily = 13.8;  // 2 ln 1000: rarer ones move no average
inline constexpr double kPriceOfPresence =
    3.8;  // 2 ln 7: one or two effects of ten, not one in 850

/// Sets in which one effect of `best` is replaced by another whose span holds its whole fitted
/// signal, all but 4 in chi^2: the readings do not carry the difference, whatever the number of
/// parameters. (No share of the signal instead: a large one is told apart by what is small in it.)
std::vector<Candidate> structural_ties(const Library& library, const Candidate& best);

/// Columns that `units` take together.
int parameter_count(const Library& library, const std::vector<int>& units);

/// Of the names and parameters of a set; the first unit of an effect costs more than further ones.
double price_of(const Library& library, const std::vector<int>& units);

/// Fall of chi^2 that `units` give together (0 for none).
double gain_of(const Library& library, const std::vector<int>& units);

std::vector<std::string> names_of(const Candidate& candidate);

}  // namespace trammel
