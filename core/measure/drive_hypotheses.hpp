#pragma once
// What wires, signs and working modes make of the drives: hypotheses of the screen.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/measure/screen.hpp"
#include "core/mechanism/machine_solver.hpp"

namespace trammel {

using Displaced = std::optional<Displacements>;

/// What the inverse kinematics make of a pose, and what the drives make of that.
struct DriveModel {
  MachineSolver solver;
  bool other_branch = false;
  std::function<Displacements(const Displacements&)> drives = [](const Displacements& l) {
    return l;
  };
};

/// (4) of inverse.hpp with the branch asked for: the plus sign is the other working mode. Nothing
/// out of reach.
Displaced displacements_at(const DriveModel& model, const Pose& pose);

struct DriveHypothesis {
  Mistake kind;
  std::string what;
  DriveModel model;
};

/// Drives that changed places or count backwards; of a 3-PRR the other working mode too.
/// Proof: tests/core/measure/mistakes_test.cpp.
std::vector<DriveHypothesis> hypotheses_of_drives(const MachineSolver& solver);

inline bool is_prr(const MachineSolver& solver) {
  return solver.machine().kind->chain == &kPrrChain;
}

/// A mistake, and how far what it says is from what was read.
struct FittedMistake {
  Suspicion suspicion;
  double left_mm;
};
inline constexpr double kNothingMm = 0.02;  // closer than this two hypotheses fit equally well

}  // namespace trammel
