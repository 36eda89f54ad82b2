#pragma once
// A small plan on the paper's virtual robot, and readings as a session must give them.

#include <map>
#include <string>
#include <vector>

#include "app/session/session.hpp"
#include "core/plan/build.hpp"
#include "core/plan/grids.hpp"
#include "store/campaign.hpp"
#include "store/open.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary.hpp"

namespace trammel::tests {

inline const std::string kPaperRobot = tests::source_folder() + "/examples/paper/robot.json";

/// Ten points of which some have directions of approach.
inline Plan small_plan() {
  PlanRequest request{.name = "small", .groups = {{"", paper_80(25, 1)}}};
  request.approaches = {Approach{0, 0, 0}, Approach{1, 0, -1}};
  return build_plan(request);
}

/// The same points, as far as a machine has coordinates and drives.
inline Plan plan_on(const Machine& machine, Plan plan) {
  const auto n = static_cast<std::size_t>(machine.kind->n_chains);
  for (PlannedPoint& point : plan.points) {
    if (n < 2) point.target.y_mm = 0;
    if (n < 3) point.target.phi_rad = machine.home.phi_rad;
    for (std::size_t i = n; i < point.approach.size(); ++i) point.approach[i] = 0;
  }
  return plan;
}

inline session::Request request_for(const Plan& plan, const std::string& session = "s") {
  session::Request request;
  request.campaign = "c";
  request.session = session;
  request.plan = plan;
  request.stage = "sim:" + kPaperRobot;
  return request;
}

/// Readings of a session by the seq of their point.
inline std::map<int, Reading> by_point(store::Connection& db, const std::string& campaign,
                                       const std::string& session) {
  const store::Id campaign_id = store::require_campaign(db, campaign).id;
  const store::Id id = store::find_session(db, campaign_id, session)->id;
  std::map<store::Id, int> seq_of;
  for (const store::Attempt& a : store::attempts(db, id)) {
    if (a.status == "ok") seq_of[a.id] = a.point_seq;
  }
  std::map<int, Reading> readings;
  for (const store::StoredReading& r : store::readings(db, campaign_id, {id})) {
    const bool first = readings.emplace(seq_of.at(*r.attempt_id), r.data.reading).second;
    if (!first) throw std::runtime_error("a point is stored twice");
  }
  return readings;
}

/// The same bits in everything but the number in the campaign and the epoch.
inline bool same_bits(const Reading& a, const Reading& b) {
  return a.target == b.target && a.set == b.set && a.measured == b.measured &&
         a.conditions.cmd_mm == b.conditions.cmd_mm &&
         a.conditions.from_mm == b.conditions.from_mm &&
         a.conditions.time_s == b.conditions.time_s &&
         a.conditions.temp_degc == b.conditions.temp_degc;
}

}  // namespace trammel::tests
