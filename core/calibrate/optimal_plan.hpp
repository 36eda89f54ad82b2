#pragma once
// Where to measure, chosen so that the readings identify best. It stands here and not in core/plan,
// since plans know nothing of models, and choosing needs the model's derivatives.

#include <cstdint>
#include <string>
#include <vector>

#include "core/calibrate/design.hpp"
#include "core/plan/check.hpp"
#include "core/plane/place.hpp"

namespace trammel {

/// What a good design is, of the information M = I + J' J in tolerances:
///   D  most det M: the smallest volume of what remains possible
///   A  least tr M^-1: the smallest mean variance of the identifiable directions
///   E  most lambda_min(M): the worst direction best
enum class Criterion { D, A, E };

struct OptimalRequest {
  std::string name = "optimal";
  int points = 40;
  Criterion criterion = Criterion::D;
  std::vector<std::string> effects = {"lead_scale", "backlash"};  // identified beside the geometry
  TrackerSigma sigma = {};
  double half_width_mm = 100;  // candidates: this square, every step, at every orientation
  double step_mm = 20;
  std::vector<Place> within = {};  // convex hull that candidates lie in; none: anywhere
  std::vector<double> orientations_rad = {};
  double approach_mm = 5;
  std::uint64_t seed = 1;
  ReadingSet set = ReadingSet::identify;
  CheckOptions check = {};  // candidates that fail are left out
};

struct OptimalPlan {
  Plan plan;
  Eigen::MatrixXd jacobian;  // of the plan, shape (3 points, parameters)
  int candidates = 0;
  int passes = 0;       // over the design until no exchange gained
  double at_start = 0;  // the criterion of the seeded random start: log det, trace, lambda_min
  double at_end = 0;
};

/// Chooses `points` of the candidates by exchange: from a seeded random start, each point in turn
/// gives way to the candidate that serves the criterion best without it, until a whole pass gains
/// nothing (Fedorov 1972, one point at a time). Candidates are all poses of the lattice at all
/// orientations, approached from each combination of directions of the drives where `effects` holds
/// one that depends on it, else as it comes. What a machine does not move stands at home. E tries
/// the candidates that stretch the weakest direction most. A point may be chosen twice: it is then
/// a repeat. Ordered by the nearest next.
/// @throws InputError  no candidate is safe, fewer than 2 or more than 2000 points
/// Proof: no single exchange improves the result, better than random and than paper-80
/// (optimal_plan_test.cpp). Deterministic for a seed.
OptimalPlan optimal_plan(const NominalMachine& machine, const OptimalRequest& request);

}  // namespace trammel
