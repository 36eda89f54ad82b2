#include "core/plan/check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <string>

#include "core/error.hpp"
#include "core/mechanism/machine_solver.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

using What = Violation::What;
using Place = Violation::Place;

class Checker {
 public:
  Checker(const Machine& machine, const CheckOptions& options)
      : solver_(machine), options_(options) {}

  [[nodiscard]] const MachineSolver& solver() const { return solver_; }

  std::vector<Violation> take() { return std::move(found_); }

  void add(int seq, Place place, What what, int rail = 0, double got = 0, double limit = 0) {
    found_.push_back({seq, place, what, rail, got, limit,
                      rail > 0 ? drive_name(solver_.machine(), rail - 1) : ""});
  }

  bool limits(int seq, Place place, const Displacements& l_mm) {
    bool inside = true;
    for (int i = 0; i < solver_.machine().kind->n_chains; ++i) {
      const Limits& limits = solver_.machine().drives[static_cast<std::size_t>(i)].limits;
      const double low = limits.l_min_mm + options_.limit_margin_mm;
      const double high = limits.l_max_mm - options_.limit_margin_mm;
      if (l_mm[i] < low) add(seq, place, What::lower_limit, i + 1, l_mm[i], low);
      if (l_mm[i] > high) add(seq, place, What::upper_limit, i + 1, l_mm[i], high);
      inside = inside && l_mm[i] >= low && l_mm[i] <= high;
    }
    return inside;
  }

  void singular(int seq, Place place, double margin) {
    if (margin < options_.singularity_margin) {
      add(seq, place, What::singular, 0, margin, options_.singularity_margin);
    }
  }

  /// Rails move in proportion. Leaves `pose` at the end; nothing when the platform cannot follow.
  std::optional<Pose> path(int seq, const Displacements& from, const Displacements& to, Pose pose,
                           Place end) {
    const double length = (to - from).cwiseAbs().maxCoeff();
    const int steps = std::max(1, static_cast<int>(std::ceil(length / options_.path_step_mm)));
    double least = std::numeric_limits<double>::infinity(), closest = least, fastest = 0;
    const Eigen::Vector3d l_dot =
        length > 0 ? Eigen::Vector3d((to - from) * (options_.speed_mm_s / length))
                   : Eigen::Vector3d::Zero();
    for (int k = 1; k <= steps; ++k) {
      const Displacements l = from + (to - from) * (static_cast<double>(k) / steps);
      const MachinePose at = solver_.pose(l, pose);
      if (!at.ok()) {
        const bool reach = at.status == MachinePose::Status::unreachable;
        add(seq, k == steps ? end : Place::path, reach ? What::unreachable : What::singular,
            reach ? at.chain + 1 : 0, reach ? l[at.chain] : 0, 0);
        return std::nullopt;
      }
      pose = at.pose;
      const MachineSolver::Look look = solver_.look(pose);
      if (k < steps) least = std::min(least, look.singularity.margin());
      closest = std::min(closest, look.clearance_mm);
      const Eigen::Vector3d X_dot = look.J_V * l_dot;
      fastest = std::max(fastest, std::hypot(X_dot[0], X_dot[1]));
    }
    singular(seq, Place::path, least);
    if (closest < options_.link_clearance_mm) {
      add(seq, Place::path, What::collision, 0, closest, options_.link_clearance_mm);
    }
    if (fastest > options_.max_platform_mm_s) {
      add(seq, Place::path, What::too_fast, 0, fastest, options_.max_platform_mm_s);
    }
    return pose;
  }

 private:
  MachineSolver solver_;
  const CheckOptions& options_;
  std::vector<Violation> found_;
};

/// Where the stage stands, and whether what it does next can be followed from there.
struct Standing {
  Displacements l_mm;
  Displacements from_mm;
  std::optional<Pose> pose;
};

/// Compensation moves a command by far less than two assemblies of the platform lie apart.
bool same_assembly(const Pose& a, const Pose& b) {
  constexpr double kNearMm = 10, kNearRad = rad_from_deg(5);
  return std::abs(a.x_mm - b.x_mm) < kNearMm && std::abs(a.y_mm - b.y_mm) < kNearMm &&
         std::abs(a.phi_rad - b.phi_rad) < kNearRad;
}

/// Looks at one point; the standing place moves on only when the target can be stood on.
void check_point(Checker& checker, const Plan& plan, const PlannedPoint& point,
                 const Displacements* command, Standing& at) {
  if (!point.target.vector().allFinite() || (command != nullptr && !command->allFinite())) {
    checker.add(point.seq, Place::target, What::not_finite);
    return;
  }
  const InverseResult solved = checker.solver().drives(point.target);
  if (!solved.ok()) {
    checker.add(point.seq, Place::target, What::unreachable, solved.chain + 1);
    return;
  }
  const Displacements cmd = command != nullptr ? *command : solved.l_mm;
  checker.limits(point.seq, Place::target, cmd);
  checker.singular(point.seq, Place::target,
                   checker.solver().look(point.target).singularity.margin());
  const PlannedMove move = planned_move(plan, point, cmd, at.l_mm, at.from_mm);
  if (move.pre_position) checker.limits(point.seq, Place::approach, move.pre_mm);
  std::optional<Pose> pose = at.pose;
  if (pose && move.pre_position) {
    pose = checker.path(point.seq, at.l_mm, move.pre_mm, *pose, Place::approach);
  }
  if (pose) pose = checker.path(point.seq, move.pre_mm, cmd, *pose, Place::target);
  if (pose && !same_assembly(*pose, point.target)) {
    checker.add(point.seq, Place::target, What::other_mode);
    pose = point.target;
  }
  at = {cmd, move.from_mm, pose ? pose : std::optional<Pose>(point.target)};
}

}  // namespace

const char* name_of(Violation::What what) {
  constexpr std::array<const char*, 9> kNames = {
      "not finite",        "out of reach",    "below lower limit",
      "above upper limit", "near singular",   "in the other assembly",
      "out of order",      "links too close", "too fast"};
  return kNames[static_cast<std::size_t>(what)];
}

const char* name_of(Violation::Place place) {
  constexpr std::array<const char*, 3> kNames = {"target", "approach", "path"};
  return kNames[static_cast<std::size_t>(place)];
}

namespace {

void require_margins(const CheckOptions& o) {
  const auto refuse = [](const char* field, double got, const char* expected) {
    throw InputError({.what = "a plan cannot be checked against this margin",
                      .where = {.field = field},
                      .got = std::to_string(got),
                      .expected = expected});
  };
  if (!(o.limit_margin_mm >= 0) || !std::isfinite(o.limit_margin_mm)) {
    refuse("limit_margin_mm", o.limit_margin_mm, "0 mm or more");
  }
  if (!(o.singularity_margin >= 0 && o.singularity_margin <= 1)) {
    refuse("singularity_margin", o.singularity_margin, "0 to 1");
  }
  if (!(o.link_clearance_mm >= 0) || !std::isfinite(o.link_clearance_mm)) {
    refuse("link_clearance_mm", o.link_clearance_mm, "0 mm or more");
  }
  const std::array<std::pair<const char*, double>, 3> speeds = {
      {{"speed_mm_s", o.speed_mm_s},
       {"max_speed_mm_s", o.max_speed_mm_s},
       {"max_platform_mm_s", o.max_platform_mm_s}}};
  for (const auto& [field, value] : speeds) {
    if (!(value > 0) || !std::isfinite(value)) refuse(field, value, "a positive speed");
  }
  if (!(o.path_step_mm > 0) || !std::isfinite(o.path_step_mm)) {
    refuse("path_step_mm", o.path_step_mm, "a positive length");
  }
}

}  // namespace

std::string describe(const Violation& v) {
  std::string text = v.seq > 0 ? "point " + std::to_string(v.seq) + ", " : "";
  text += std::string(name_of(v.place)) + ": ";
  if (!v.drive.empty()) text += v.drive + " ";
  text += name_of(v.what);
  if (v.got == 0 && v.limit == 0) return text;
  std::array<char, 80> numbers{};
  const char* format = v.what == What::singular     ? ": margin %.3f, at least %.3f"
                       : v.what == What::disordered ? ": got %.0f, expected %.0f"
                       : v.what == What::too_fast   ? ": %.1f mm/s, limit %.1f mm/s"
                                                    : ": %.3f mm, limit %.3f mm";
  std::snprintf(numbers.data(), numbers.size(), format, v.got, v.limit);
  return text + numbers.data();
}

void require_plan_of(const Machine& machine, const Plan& plan) {
  const Eigen::Vector3d home = machine.home.vector();
  for (const PlannedPoint& point : plan.points) {
    const Eigen::Vector3d target = point.target.vector();
    for (int c = machine.kind->n_chains; c < 3; ++c) {
      const auto coordinate = static_cast<std::size_t>(c);
      const bool goes = target[c] != home[c], arrives = point.approach[coordinate] != 0;
      if (!goes && !arrives) continue;
      const std::string kind(machine.kind->name);
      throw InputError(
          {.what = "this plan is of another machine",
           .where = {.field = goes ? std::string(kCoordinateNames[coordinate]) : "approach",
                     .point = std::to_string(point.seq)},
           .got = goes ? std::to_string(c == 2 ? deg_from_rad(target[c]) : target[c])
                       : "a direction of drive " + std::to_string(c + 1),
           .expected = goes ? std::string(kCoordinateNames[coordinate]) + " at home: an " + kind +
                                  " machine does not move along it"
                            : "0: an " + kind + " machine has " +
                                  std::to_string(machine.kind->n_chains) +
                                  (machine.kind->n_chains == 1 ? " drive" : " drives"),
           .hint = "make one for it: trammel plan create lattice --mechanism FILE"});
    }
  }
}

std::vector<Violation> check(const Plan& plan, const Machine& machine, const CheckOptions& options,
                             std::span<const Displacements> commands) {
  TRAMMEL_ASSERT(commands.empty() || commands.size() == plan.points.size());
  require_margins(options);
  Checker checker(machine, options);
  const InverseResult home = checker.solver().drives(machine.home);
  if (!home.ok()) {
    checker.add(0, Place::target, What::unreachable, home.chain + 1);
    return checker.take();
  }
  if (options.speed_mm_s > options.max_speed_mm_s) {
    checker.add(0, Place::target, What::too_fast, 0, options.speed_mm_s, options.max_speed_mm_s);
  }
  require_plan_of(machine, plan);
  Standing at{home.l_mm, home.l_mm, machine.home};
  for (std::size_t k = 0; k < plan.points.size(); ++k) {
    const PlannedPoint& point = plan.points[k];
    if (point.seq != static_cast<int>(k) + 1) {
      checker.add(point.seq, Place::target, What::disordered, 0, point.seq,
                  static_cast<double>(k) + 1);
    }
    check_point(checker, plan, point, commands.empty() ? nullptr : &commands[k], at);
  }
  return checker.take();
}

std::vector<Violation> check_path(const Machine& machine, std::span<const Displacements> waypoints,
                                  const CheckOptions& options) {
  require_margins(options);
  Checker checker(machine, options);
  const InverseResult home = checker.solver().drives(machine.home);
  if (!home.ok()) {
    checker.add(0, Place::target, What::unreachable, home.chain + 1);
    return checker.take();
  }
  Displacements at = home.l_mm;
  std::optional<Pose> pose = machine.home;
  int seq = 0;
  for (const Displacements& to : waypoints) {
    ++seq;
    if (!to.allFinite()) {
      checker.add(seq, Place::target, What::not_finite);
      break;
    }
    checker.limits(seq, Place::target, to);
    pose = checker.path(seq, at, to, *pose, Place::target);
    if (!pose) break;  // nothing is known beyond
    at = to;
  }
  return checker.take();
}

std::vector<Violation> check_move(const Machine& machine, const Displacements& from_mm,
                                  const Pose& near, const Displacements& to_mm,
                                  const CheckOptions& options) {
  require_margins(options);
  Checker checker(machine, options);
  const MachinePose start = from_mm.allFinite() && to_mm.allFinite()
                                ? checker.solver().pose(from_mm, near)
                                : MachinePose{};
  if (!start.ok()) {
    checker.add(0, Place::target, What::not_finite);
    return checker.take();
  }
  if (options.speed_mm_s > options.max_speed_mm_s) {
    checker.add(0, Place::target, What::too_fast, 0, options.speed_mm_s, options.max_speed_mm_s);
  }
  checker.limits(0, Place::target, to_mm);
  static_cast<void>(checker.path(0, from_mm, to_mm, start.pose, Place::target));
  return checker.take();
}

}  // namespace trammel
