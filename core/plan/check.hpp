#pragma once
// Before anything moves: every target, and the path to it.

#include <span>
#include <string>
#include <vector>

#include "core/mechanism/machine.hpp"
#include "core/plan/plan.hpp"

namespace trammel {

struct CheckOptions {
  double limit_margin_mm = 2;       // of stroke that stays free at either end
  double singularity_margin = 0.1;  // of Singularity::margin(); the paper's points have over 0.3
  double path_step_mm = 2;          // rails are looked at this often on the way
  double link_clearance_mm = 10;    // between centre lines of links, and of a link and the platform
  double speed_mm_s = 20;           // of the fastest rail, as the stage will be given it
  double max_speed_mm_s = 200;      // that a rail may go; a speed is refused, never lowered
  double max_platform_mm_s = 500;   // that the reflector may go on the way
};

/// One thing that is wrong with a plan: at which point, what, and by how much.
struct Violation {
  enum class What {
    not_finite,
    unreachable,
    lower_limit,
    upper_limit,
    singular,
    other_mode,  // the rails get there, the platform ends up in the mirrored assembly
    disordered,
    collision,  // a link comes too close to another or to the platform
    too_fast,   // a rail, or the platform where a small move of the rails is a large one of it
  };
  enum class Place { target, approach, path };  // path: on the way to the point
  int seq = 0;
  Place place = Place::target;
  What what = What::not_finite;
  int rail = 0;      // from 1; 0 where it is no drive's fault
  double got = 0;    // displacement or distance in mm, speed in mm/s, or the singularity margin
  double limit = 0;  // what it was held against
  std::string drive = {};  // "rail 2", "y axis"; empty where it is no drive's fault
};
const char* name_of(Violation::What what);
const char* name_of(Violation::Place place);

/// "point 7, path: rail 2 above upper limit: 611.200 mm, limit 598.000 mm".
std::string describe(const Violation& violation);

/// All violations in order of seq, none when the plan is safe. `commands`, one per point, are the
/// displacements that will be commanded; without them the nominal ones. The stage starts at home
/// and moves its rails in proportion (straight in joint space), first to the start of the approach.
/// Throws InputError for margins that check nothing: not finite, negative; and for a plan of
/// another machine, as require_plan_of.
/// Proof: one plan per kind of violation, and all kinds in one plan (check_test.cpp).
std::vector<Violation> check(const Plan& plan, const Machine& machine,
                             const CheckOptions& options = {},
                             std::span<const Displacements> commands = {});

/// The same for bare displacements, one after the other from home: limits, reach and singularity at
/// each and on the way. seq is the number of the waypoint, from 1.
std::vector<Violation> check_path(const Machine& machine, std::span<const Displacements> waypoints,
                                  const CheckOptions& options = {});

/// One move, when it is sent: from where the rails stand to `to_mm`. `near` is a pose close to
/// where the platform stands. seq is 0. Proof: check_test.cpp, and 1,000 unsafe plans in
/// safety_test.cpp.
std::vector<Violation> check_move(const Machine& machine, const Displacements& from_mm,
                                  const Pose& near, const Displacements& to_mm,
                                  const CheckOptions& options = {});

/// Throws InputError that names the first point which asks of the machine what it has not: a
/// coordinate away from home, a direction of a drive. Proof: check_test.cpp.
void require_plan_of(const Machine& machine, const Plan& plan);

/// Of the paper's robot as parts of the program still hold it.
inline std::vector<Violation> check(const Plan& plan, const Mechanism& mechanism,
                                    const CheckOptions& options = {},
                                    std::span<const Displacements> commands = {}) {
  return check(plan, machine_of(mechanism), options, commands);
}
inline std::vector<Violation> check_path(const Mechanism& mechanism,
                                         std::span<const Displacements> waypoints,
                                         const CheckOptions& options = {}) {
  return check_path(machine_of(mechanism), waypoints, options);
}

}  // namespace trammel
