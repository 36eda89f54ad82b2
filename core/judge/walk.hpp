#pragma once
// Walks through the points of a plan, and which of them are compared with which.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/measure/reading.hpp"

namespace trammel {

/// One measured point.
struct Visit {
  int point = 0;          // in the plan of its walk, from 1
  std::string role = {};  // "circle 1"
  Reading reading = {};
};
bool on_circle(const Visit& visit);

/// One session: what was planned, and what was measured of it.
struct Walk {
  std::optional<std::int64_t> compensation = {};  // which correction the robot had; none: baseline
  std::vector<Pose> plan = {};  // targets in their order; none where readings came without a plan
  int n_asked = 0;  // points it was to have, where more than the targets that are known (imported)
  int n_done = 0;   // points of the plan with a reading, excluded ones too
  std::vector<Visit> visits = {};  // those that count, in the order of measurement
};

/// Every point of the plan was measured.
bool complete(const Walk& walk);

/// The same targets in the same order, as far as both are known, and as many.
bool same_plan(const Walk& a, const Walk& b);

/// Whether figures may be made of walk k. A compensated walk stands when it is complete. A baseline
/// that was not finished stands as far as it went, unless a complete one has its plan. A walk with
/// no reading does not stand. Proof for all of this file: walk_test.cpp.
bool stands(std::span<const Walk* const> walks, std::size_t k);

/// The baseline that walk k, a compensated one, is compared with: of those that stand the one that
/// shares most of its visits, of equals the first; none where nothing is shared.
std::optional<std::size_t> baseline_of(std::span<const Walk* const> walks, std::size_t k);

/// Indices of visits before and after that are of one target: the same point where the walks have
/// one plan, else the k-th visit of a target with the k-th. In the order of `before`.
using VisitPairs = std::vector<std::pair<std::size_t, std::size_t>>;
VisitPairs pair_visits(std::span<const Visit* const> before, std::span<const Visit> after,
                       bool one_plan);

}  // namespace trammel
