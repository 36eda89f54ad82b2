// Homing, epochs, and whether the reference points are where they were.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/session/runner.hpp"
#include "core/plan/check.hpp"
#include "core/units.hpp"

namespace trammel::session {

namespace {

constexpr int kReferences = 3;
constexpr std::uint64_t kReferenceReadings = 1'000'000'000'000'000;  // beyond those of any session
constexpr std::uint64_t kReadingsPerEpoch = 1'000'000;

/// The stored points to visit again: those the plan marks, else the first ones.
std::vector<PlannedPoint> references_of(const Plan& plan,
                                        const std::map<int, store::StoredReading>& measured) {
  std::vector<PlannedPoint> marked, first;
  for (const PlannedPoint& point : plan.points) {
    if (!measured.contains(point.seq)) continue;
    if (point.reference) marked.push_back(point);
    if (first.size() < kReferences) first.push_back(point);
  }
  return marked.empty() ? first : marked;
}

store::NewSession reference_session(const Course& course, store::Connection& connection,
                                    const std::vector<PlannedPoint>& points) {
  store::NewSession session;
  session.campaign_id = course.campaign.id;
  int number = 1;
  do {
    session.name = fmt::format("{}, reference {}", course.session.name, number++);
  } while (store::find_session(connection, course.campaign.id, session.name));
  session.compensation_job = course.session.compensation_job;
  session.plan_name = "reference points";
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

}  // namespace

std::string Runner::moved(const store::StoredReading& before, const Reading& now) const {
  const Eigen::Vector3d d = now.measured->vector() - before.data.reading.measured->vector();
  ReferenceTolerance tolerance;
  if (devices_.sigma) {
    const double six_of_difference = 6 * std::sqrt(2.0);
    tolerance.xy_mm = std::max(tolerance.xy_mm, six_of_difference * devices_.sigma->xy_mm);
    tolerance.phi_rad = std::max(tolerance.phi_rad, six_of_difference * devices_.sigma->phi_rad);
  }
  const double off_mm = std::hypot(d[0], d[1]);
  if (off_mm <= tolerance.xy_mm && std::abs(d[2]) <= tolerance.phi_rad) return "";
  return fmt::format(
      "reading {} was measured again {:.3f} mm and {:.3f} deg away "
      "(tolerance {:.3f} mm, {:.3f} deg)",
      before.data.reading.seq, off_mm, deg_from_rad(d[2]), tolerance.xy_mm,
      deg_from_rad(tolerance.phi_rad));
}

/// By the move it was measured after the first time.
Runner::Failure Runner::revisit(const store::StoredReading& before, std::uint64_t number,
                                store::NewReading& again) {
  const Conditions& then = before.data.reading.conditions;
  Failure failure = move(then.from_mm);
  if (!failure.any()) failure = move(then.cmd_mm);
  if (failure.any()) return failure;
  Reading reading;
  reading.target = before.data.reading.target;
  reading.conditions.cmd_mm = then.cmd_mm;
  reading.conditions.from_mm = then.from_mm;
  const device::Occasion occasion{
      .reading = kReferenceReadings +
                 kReadingsPerEpoch * static_cast<std::uint64_t>(epoch_.number) + number,
      .time_s = devices_.clock->time_s(open_.front()),
      .epoch = epoch_.number};
  return read(occasion, reading, again);
}

bool Runner::references_hold(int& epoch_number) {
  const std::vector<PlannedPoint> points = references_of(course_.plan, measured_);
  const store::Id session =
      store::create_session(connection_, reference_session(course_, connection_, points));
  epoch_ = store::open_epoch(connection_, session, store::SetUp::fresh,
                             "resume of " + course_.session.name);
  epoch_number = epoch_.number;
  std::vector<Displacements> way;
  for (const PlannedPoint& point : points) {
    const Conditions& then = measured_.at(point.seq).data.reading.conditions;
    way.insert(way.end(), {then.from_mm, then.cmd_mm});
  }
  const Standing start = start_of(open_.front());
  way.insert(way.end(), {start.from_mm, start.l_mm});
  const auto violations = check_path(devices_.mechanism, way, course_.settings.check);
  if (!violations.empty()) {
    fail("the way over the reference points is not safe: " + describe(violations.front()));
    return false;
  }
  int seq = 0;
  std::string off;
  for (const PlannedPoint& point : points) {
    const store::Id attempt = store::begin_attempt(connection_, session, ++seq, epoch_.id);
    store::NewReading again;
    const Failure failure =
        revisit(measured_.at(point.seq), static_cast<std::uint64_t>(seq), again);
    if (failure.any()) {
      static_cast<void>(devices_.stage->stop());
      const std::string what = device::name_of(failure.status) + (": " + failure.detail);
      store::fail_attempt(connection_, attempt, what);
      fail(fmt::format("reference point {}: {}", point.seq, what));
      return false;
    }
    store::finish_attempt(connection_, attempt, {again});
    if (off.empty()) off = moved(measured_.at(point.seq), again.reading);
  }
  if (off.empty()) return true;
  fail("the set-up has moved: " + off);
  return false;
}

bool Runner::set_up(bool resuming, bool new_set_up) {
  if (asked_to_stop(1)) {
    advance(Event::stop_asked);
    return false;
  }
  if (!devices_.stage->homed()) {
    const Failure failure = home();
    if (failure.any()) {
      static_cast<void>(devices_.stage->stop());
      fail("homing: " + failure.detail);
      return false;
    }
  }
  const store::Id id = course_.session.id;
  if (!resuming) {
    epoch_ = store::open_epoch(connection_, id,
                               new_set_up ? store::SetUp::fresh : store::SetUp::as_before,
                               new_set_up ? "first homing of the set-up" : "set-up as before");
    return true;
  }
  if (open_.empty() || measured_.empty()) {
    epoch_ = store::open_epoch(connection_, id, store::SetUp::fresh, "resume");
    return true;
  }
  int number = 0;
  if (!references_hold(number)) return false;
  epoch_.id = store::add_epoch(connection_, id, number, "resume, reference points hold");
  epoch_.number = number;
  return true;
}

}  // namespace trammel::session
