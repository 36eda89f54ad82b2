// Homing, epochs, and whether the reference points are where they were.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/session/base_check.hpp"
#include "app/session/runner.hpp"
#include "core/plan/check.hpp"
#include "core/units.hpp"

namespace trammel::session {

namespace {

constexpr std::size_t kReferences = 3;
constexpr std::uint64_t kReferenceReadings = 1'000'000'000'000'000;  // beyond those of any session
constexpr std::uint64_t kReadingsPerEpoch = 1'000'000;
constexpr std::uint64_t kReadingsPerVisit = 1'000;

store::NewSession reference_session(const Course& course, store::Connection& connection,
                                    const std::vector<PlannedPoint>& points) {
  store::NewSession session;
  session.campaign_id = course.campaign.id;
  int number = 1;
  do {
    session.name = fmt::format("{}, reference {}", course.session.name, number++);
  } while (store::find_session(connection, course.campaign.id, session.name));
  session.compensation_job = course.session.compensation_job;
  session.plan_name = store::kReferencePlan;
  session.stage = course.session.stage;
  session.tracker = course.session.tracker;
  int seq = 0;
  for (const PlannedPoint& p : points) {
    session.points.push_back(
        {.seq = ++seq,
         .set = ReadingSet::identify,  // they determine the new epoch's offset
         .target = p.target,
         .approach = p.approach,
         .repeat = p.repeat,
         .reference = true,
         .role = fmt::format("reference to point {}", p.seq),
         .planned_mm = course.planned_mm[static_cast<std::size_t>(p.seq) - 1]});
  }
  return session;
}

/// Empty: within the tolerance.
std::string moved(const store::StoredReading& before, const Reading& now,
                  const ReferenceTolerance& tolerance) {
  const Eigen::Vector3d d = now.measured->vector() - before.data.reading.measured->vector();
  const double off_mm = std::hypot(d[0], d[1]);
  if (off_mm <= tolerance.xy_mm && std::abs(d[2]) <= tolerance.phi_rad) return "";
  return fmt::format(
      "reading {} was measured again {:.3f} mm and {:.3f} deg away "
      "(tolerance {:.3f} mm, {:.3f} deg)",
      before.data.reading.seq, off_mm, deg_from_rad(d[2]), tolerance.xy_mm,
      deg_from_rad(tolerance.phi_rad));
}

}  // namespace

ReferenceTolerance Runner::at_least_noise(ReferenceTolerance tolerance) const {
  if (!devices_->sigma) return tolerance;
  const double six_of_difference = 6 * std::sqrt(2.0);
  return {std::max(tolerance.xy_mm, six_of_difference * devices_->sigma->xy_mm),
          std::max(tolerance.phi_rad, six_of_difference * devices_->sigma->phi_rad)};
}

/// The stored points to visit again: those the plan marks, else the first ones.
std::vector<PlannedPoint> Runner::references() const {
  std::vector<PlannedPoint> marked, first;
  for (const PlannedPoint& point : course_.plan.points) {
    if (!measured_.contains(point.seq)) continue;
    if (point.reference) marked.push_back(point);
    if (first.size() < kReferences) first.push_back(point);
  }
  return marked.empty() ? first : marked;
}

/// The points stored since the last look at the base nests that found them in place.
Runner::Doubt Runner::doubt() const {
  Doubt doubt;
  std::size_t trusted = 0;  // points
  for (const store::Event& event : store::events(connection_, course_.session.id)) {
    if (event.kind != kBaseEvent) continue;
    const std::optional<BaseCheck> check = read_base_check(event.detail);
    if (!check) continue;
    doubt.moved = check->off;
    if (!check->off) trusted = static_cast<std::size_t>(check->after);
  }
  for (std::size_t k = trusted; k < course_.plan.points.size(); ++k) {
    if (measured_.contains(course_.plan.points[k].seq)) {
      doubt.points.push_back(course_.plan.points[k]);
    }
  }
  return doubt;
}

/// By the move it was measured after the first time.
Failure Runner::revisit(const store::StoredReading& before, const device::Occasion& occasion,
                        store::NewReading& again) {
  const Conditions& then = before.data.reading.conditions;
  Failure failure = hands_.move(then.from_mm);
  if (!failure.any()) failure = hands_.move(then.cmd_mm);
  if (!failure.any()) failure = hands_.beam();
  if (failure.any()) return failure;
  again.reading.target = before.data.reading.target;
  again.reading.conditions.cmd_mm = then.cmd_mm;
  again.reading.conditions.from_mm = then.from_mm;
  return read(occasion, again);
}

/// In a session of their own, each tried as a point is. `next`: where the stage goes after them.
Runner::Visit Runner::visit(const std::vector<PlannedPoint>& points, store::SetUp set_up,
                            const ReferenceTolerance& tolerance, const PlannedPoint& next) {
  const store::NewSession visits = reference_session(course_, connection_, points);
  const store::Id session = store::create_session(connection_, visits);
  const store::Epoch epoch = store::open_epoch(connection_, session, set_up,
                                               "reference points of " + course_.session.name);
  Visit found{.failure = {}, .off = {}, .epoch = epoch.number};
  std::vector<Displacements> way = {hands_.place().l_mm};
  for (const PlannedPoint& point : points) {
    const Conditions& then = measured_.at(point.seq).data.reading.conditions;
    way.insert(way.end(), {then.from_mm, then.cmd_mm});
  }
  const Standing start = start_of(next);
  way.insert(way.end(), {start.from_mm, start.l_mm});
  const auto violations = check_path(devices_->machine, way, course_.settings.check);
  if (!violations.empty()) {
    found.failure =
        unsafe("the way over the reference points is not safe: " + describe(violations.front()));
    return found;
  }
  device::Occasion occasion{
      .reading = kReferenceReadings + kReadingsPerEpoch * static_cast<std::uint64_t>(epoch.number) +
                 kReadingsPerVisit * static_cast<std::uint64_t>(n_visits_++),
      .time_s = devices_->clock->time_s(next),
      .epoch = epoch.number};
  int seq = 0;
  for (const PlannedPoint& point : points) {
    const store::StoredReading& before = measured_.at(point.seq);
    ++seq;
    ++occasion.reading;
    store::NewReading again;
    found.failure =
        try_hard({.session = session,
                  .session_name = visits.name,
                  .seq = seq,
                  .epoch = epoch,
                  .walks = false,
                  .once = [&](store::NewReading& r) { return revisit(before, occasion, r); }},
                 again);
    if (found.failure.any()) {
      found.failure.detail = fmt::format("reference point {}: {}", point.seq, found.failure.detail);
      return found;
    }
    if (found.off.empty()) found.off = moved(before, again.reading, tolerance);
  }
  since_visit_ = 0;
  return found;
}

bool Runner::set_up(bool resuming, bool new_set_up) {
  stepped_.clear();
  if (asked_to_stop()) {
    advance(Event::stop_asked);
    return false;
  }
  if (!devices_->stage->homed()) {
    const Failure failure = hands_.home();
    if (failure.any()) {
      static_cast<void>(hands_.stop());
      end_with(failure, "homing");
      return false;
    }
  } else if (!hands_.on_course()) {
    const Failure failure = hands_.stop();  // homed by an earlier program: where does it stand?
    if (failure.any()) {
      end_with(failure, "stage");
      return false;
    }
  }
  const store::Id id = course_.session.id;
  n_visits_ = 0;
  if (!resuming) {
    epoch_ = store::open_epoch(connection_, id,
                               new_set_up ? store::SetUp::fresh : store::SetUp::as_before,
                               new_set_up ? "first homing of the set-up" : "set-up as before");
    return true;
  }
  const Doubt unproven = doubt();
  const bool looks = !devices_->virtual_time && devices_->tracker->sees_base();
  if (!unproven.points.empty() && (unproven.moved || (open_.empty() && looks))) {
    return settle(unproven, "resume");
  }
  if (!open_.empty() && !measured_.empty()) return references_hold();
  epoch_ = store::open_epoch(connection_, id, store::SetUp::fresh, "resume");
  return true;
}

/// In a new set-up: the points are where they were, and its epoch is open.
void Runner::begin_epoch(int number) {
  epoch_.id = store::add_epoch(connection_, course_.session.id, number, store::kReferencesHold);
  epoch_.number = number;
}

/// The reference points, and the last one, which a tracker that was knocked after them has moved
/// (what is simulated can't be knocked).
bool Runner::references_hold() {
  std::vector<PlannedPoint> points = references();
  const int last = measured_.rbegin()->first;
  if (!devices_->virtual_time && !std::ranges::count(points, last, &PlannedPoint::seq)) {
    points.push_back(course_.plan.points[static_cast<std::size_t>(last) - 1]);
  }
  const Visit found = visit(points, store::SetUp::fresh, at_least_noise({}), open_.front());
  if (found.failure.any()) {
    end_with(found.failure, "resume");
  } else if (!found.off.empty()) {
    fail("the set-up has moved: " + found.off, ExitCode::safety_stop);
  } else {
    begin_epoch(found.epoch);
    return true;
  }
  return false;
}

/// The last points in doubt are measured again in a new set-up, its frame registered anew. Those
/// measured under base nests that had moved are excluded, all of them, unless these are where they
/// were. Last to first: what creeps on would be as far off again in the order of the first time.
/// True: it goes on, in the new epoch.
bool Runner::settle(const Doubt& doubt, const std::string& when) {
  const auto n = static_cast<std::ptrdiff_t>(std::min(kReferences, doubt.points.size()));
  const std::vector<PlannedPoint> last(doubt.points.rbegin(), doubt.points.rbegin() + n);
  const bool whole = stood_.size() == course_.plan.points.size();
  const Visit found =
      visit(last, store::SetUp::fresh, at_least_noise({.xy_mm = course_.settings.policy.drift_mm}),
            whole ? course_.plan.points.back() : open_.front());
  if (found.failure.any()) {
    end_with(found.failure, when);
    return false;
  }
  if (!found.off.empty()) {
    std::string why = when + ": " + found.off;
    why += doubt.moved ? exclude(doubt.points, why)
                       : "; exclude what is wrong (`trammel reading exclude`), then resume";
    if (whole || !doubt.moved) {
      fail(why, ExitCode::safety_stop);
      return false;
    }
    progress_->say(why);
  }
  begin_epoch(found.epoch);
  return true;
}

}  // namespace trammel::session
