#include "core/plan/plan.hpp"

#include <cmath>
#include <string>

#include "core/error.hpp"

namespace trammel {

PlannedMove planned_move(const Plan& plan, const PlannedPoint& point, const Displacements& cmd_mm,
                         const Displacements& at_mm, const Displacements& at_from_mm) {
  PlannedMove move{at_mm, at_from_mm, false};
  for (int i = 0; i < kChains; ++i) {
    const int direction = point.approach[static_cast<std::size_t>(i)];
    if (direction != 0) {
      move.pre_mm[i] = cmd_mm[i] - direction * plan.approach_mm;
      move.pre_position = true;
    }
    if (std::abs(cmd_mm[i] - move.pre_mm[i]) > kStandstillMm) move.from_mm[i] = move.pre_mm[i];
  }
  return move;
}

namespace {

void require(bool ok, const PlannedPoint& point, const std::string& field, const std::string& got,
             const std::string& expected) {
  if (ok) return;
  throw InputError({.what = "the plan is not usable",
                    .where = {.field = field, .point = std::to_string(point.seq)},
                    .got = got,
                    .expected = expected});
}

}  // namespace

void validate(const Plan& plan) {
  if (plan.points.empty()) throw InputError({.what = "the plan has no points"});
  if (!(std::isfinite(plan.approach_mm) && plan.approach_mm > 0)) {
    throw InputError({.what = "the plan is not usable",
                      .where = {.field = "approach_mm"},
                      .got = std::to_string(plan.approach_mm),
                      .expected = "a positive length"});
  }
  int seq = 0;
  for (const PlannedPoint& point : plan.points) {
    ++seq;
    require(point.seq == seq, point, "seq", std::to_string(point.seq),
            std::to_string(seq) + ": points are numbered 1, 2, …");
    require(point.target.vector().allFinite(), point, "target",
            std::to_string(point.target.x_mm) + ", " + std::to_string(point.target.y_mm) + ", " +
                std::to_string(point.target.phi_rad),
            "finite numbers");
    for (const int direction : point.approach) {
      require(direction >= -1 && direction <= 1, point, "approach", std::to_string(direction),
              "-1, 0 or 1");
    }
    require(point.repeat >= 1, point, "repeat", std::to_string(point.repeat), "1 or more");
  }
}

}  // namespace trammel
