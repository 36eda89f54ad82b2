#include "app/job/next_points_plan.hpp"

#include "core/units.hpp"

namespace trammel::job {

Plan next_points_plan(const Json& diagnosis) {
  Plan plan;
  plan.name = kNextPoints;
  for (const Json& p : diagnosis["next_points"]) {
    PlannedPoint point;
    point.seq = static_cast<int>(plan.points.size()) + 1;
    point.target = {p["x_mm"], p["y_mm"], rad_from_deg(p["phi_deg"])};
    point.approach = p["approach"].get<Approach>();
    point.group = p["why"];
    plan.points.push_back(point);
  }
  return plan;
}

}  // namespace trammel::job
