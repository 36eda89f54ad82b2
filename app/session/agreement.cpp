#include "app/session/agreement.hpp"

#include <fmt/format.h>

#include "app/device/open.hpp"
#include "app/session/settings.hpp"
#include "app/terminal/counted.hpp"
#include "core/units.hpp"
#include "store/job.hpp"

namespace trammel::session {

namespace {

constexpr double kSame = 1e-9;  // mm, rad: the rounding of another compiler

[[noreturn]] void refuse(const store::SessionRow& stored, const std::string& other,
                         const std::string& got, const std::string& expected) {
  throw InputError({.what = fmt::format("session '{}' is stored, and {}", stored.name, other),
                    .where = {.field = "session"},
                    .got = got,
                    .expected = expected,
                    .hint = "give the session or the campaign another name, or put the file back"});
}

std::string words(const PlannedPoint& p) {
  return fmt::format("point {} at ({:g}, {:g}) mm, {:g} deg, {}, approach {} {} {}", p.seq,
                     p.target.x_mm, p.target.y_mm, deg_from_rad(p.target.phi_rad),
                     p.set == ReadingSet::validate ? "validate" : "identify", p.approach[0],
                     p.approach[1], p.approach[2]);
}

bool same(const PlannedPoint& a, const PlannedPoint& b) {
  return (a.target.vector() - b.target.vector()).cwiseAbs().maxCoeff() <= kSame && a.set == b.set &&
         a.approach == b.approach && a.repeat == b.repeat;
}

void require_same_plan(store::Connection& connection, const store::SessionRow& stored,
                       const Plan& plan) {
  const std::string other = "its plan is another";
  const auto points = store::points(connection, stored.id);
  if (points.size() != plan.points.size()) {
    refuse(stored, other,
           fmt::format("{} of {}", stored.plan_name, terminal::counted(points.size(), "point")),
           fmt::format("{} of {}", plan.name, terminal::counted(plan.points.size(), "point")));
  }
  for (std::size_t k = 0; k < points.size(); ++k) {
    const store::Point& p = points[k];
    const PlannedPoint was{p.seq, p.target, p.set, p.approach, p.repeat, p.reference, p.role};
    if (!same(was, plan.points[k])) refuse(stored, other, words(was), words(plan.points[k]));
  }
}

/// A job's key says all that its result depends on; a forced second run has the same.
std::string correction_words(store::Connection& connection, const std::optional<store::Id>& job) {
  if (!job) return "no correction";
  const store::Job found = store::get_job(connection, *job);
  return fmt::format("{} {}", found.data.stage, found.data.key.key.substr(0, 16));
}

}  // namespace

void require_same(store::Connection& connection, const store::SessionRow& stored,
                  const Request& request) {
  require_same_plan(connection, stored, request.plan);
  const std::string was = correction_words(connection, stored.compensation_job);
  const std::string wanted = correction_words(connection, request.compensation_job);
  if (was != wanted) refuse(stored, "it was measured under another correction", was, wanted);
  if (!has_settings(stored.settings_json) || !request.stage.starts_with("sim:")) return;
  const Settings settings = read_settings(stored.settings_json);
  if (settings.approach_mm != request.plan.approach_mm) {
    refuse(stored, "its last moves have another length",
           fmt::format("{:g} mm", settings.approach_mm),
           fmt::format("{:g} mm", request.plan.approach_mm));
  }
  if (settings.identity != device::open_devices(request.stage, request.tracker).identity) {
    refuse(stored, "it was measured on another virtual robot", "the file as it is now",
           request.stage + " as it was");
  }
}

}  // namespace trammel::session
