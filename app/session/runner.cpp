#include "app/session/runner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/mechanism/inverse.hpp"

namespace trammel::session {

namespace {

constexpr std::uint64_t kReadingsPerSession = 10'000'000;

Displacements home_of(const Mechanism& mechanism) {
  const InverseResult home = inverse(mechanism.geometry, mechanism.home);
  if (!home.ok()) throw InputError({.what = "the home pose is out of reach"});
  return home.l_mm;
}

double deviation_mm(const Reading& reading) {
  const Pose& m = *reading.measured;
  return std::hypot(m.x_mm - reading.target.x_mm, m.y_mm - reading.target.y_mm);
}

}  // namespace

std::vector<Displacements> planned_commands(const Plan& plan, const Mechanism& mechanism,
                                            const Correction& correction) {
  std::vector<Displacements> commands;
  Displacements at = home_of(mechanism), at_from = at;
  for (const PlannedPoint& point : plan.points) {
    const Move move{.target = point.target, .from_mm = at, .approach = point.approach};
    const InverseResult cmd = commanded(correction, mechanism, move);
    if (!cmd.ok()) {
      throw InputError({.what = fmt::format("a target is out of reach of chain {}", cmd.chain + 1),
                        .where = {.point = fmt::format("seq {}", point.seq)}});
    }
    at_from = planned_move(plan, point, cmd.l_mm, at, at_from).from_mm;
    at = cmd.l_mm;
    commands.push_back(at);
  }
  return commands;
}

Runner::Runner(store::Connection& connection, device::Devices& devices, const Course& course,
               const Surroundings& surroundings)
    : connection_(connection), devices_(devices), course_(course), surroundings_(surroundings) {
  home_.l_mm = home_.from_mm = home_of(devices.mechanism);
  stage_ = home_;
}

void Runner::advance(Event event) {
  const std::optional<State> to = next(state_, event);
  TRAMMEL_ASSERT(to.has_value());
  state_ = *to;
}

bool Runner::asked_to_stop(int least) const { return surroundings_.stop_signals() >= least; }

Runner::Failure Runner::move(const Displacements& to_mm) {
  const device::StageReport report =
      devices_.stage->move(to_mm, [this] { return devices_.tracker->beam(); });
  if (!report.ok()) {
    on_course_ = false;
    return {report.status, report.detail};
  }
  for (int i = 0; i < kChains; ++i) {
    if (std::abs(to_mm[i] - stage_.l_mm[i]) > kStandstillMm) stage_.from_mm[i] = stage_.l_mm[i];
  }
  stage_.l_mm = to_mm;
  return {};
}

Runner::Failure Runner::home() {
  const device::StageReport report = devices_.stage->home();
  if (!report.ok()) return {report.status, report.detail};
  stage_ = home_;
  on_course_ = true;
  return {};
}

Runner::Standing Runner::start_of(const PlannedPoint& point) const {
  const auto before = stood_.find(point.seq - 1);
  return before == stood_.end() ? home_ : before->second;
}

/// Where the plan has the stage before this point, however it came here: a repeated try or a resume
/// approaches from the same side as an undisturbed walk.
Runner::Failure Runner::stand_before(const PlannedPoint& point) {
  const Standing start = start_of(point);
  if (on_course_ && stage_.l_mm == start.l_mm && stage_.from_mm == start.from_mm) return {};
  if (start.l_mm == home_.l_mm) return home();
  Failure failure = move(start.from_mm);
  if (!failure.any()) failure = move(start.l_mm);
  on_course_ = !failure.any();
  return failure;
}

device::Occasion Runner::occasion_of(const PlannedPoint& point) {
  return {.reading = static_cast<std::uint64_t>(course_.settings.ordinal) * kReadingsPerSession +
                     static_cast<std::uint64_t>(point.seq),
          .time_s = devices_.clock->time_s(point),
          .epoch = epoch_.number};
}

Runner::Failure Runner::drive(const PlannedPoint& point, const device::Occasion& occasion,
                              Reading& reading) {
  Failure failure = stand_before(point);
  if (failure.any()) return failure;
  const device::TemperatureReport machine = devices_.thermometer->read(occasion);
  if (!machine.ok()) return {machine.status, "thermometer: " + machine.detail};
  const InverseResult cmd = commanded(course_.correction, devices_.mechanism,
                                      {.target = point.target,
                                       .from_mm = stage_.l_mm,
                                       .approach = point.approach,
                                       .epoch = epoch_.number,
                                       .time_s = occasion.time_s,
                                       .temp_degc = machine.temp_degc});
  const Displacements& planned = course_.planned_mm[static_cast<std::size_t>(point.seq) - 1];
  if (!cmd.ok() || !((cmd.l_mm - planned).cwiseAbs().maxCoeff() <= kMaxFromPlannedMm)) {
    return {device::Status::fault,
            fmt::format("the command is more than {} mm from what was checked", kMaxFromPlannedMm)};
  }
  const PlannedMove way = planned_move(course_.plan, point, cmd.l_mm, stage_.l_mm, stage_.from_mm);
  if (way.pre_position) failure = move(way.pre_mm);
  if (!failure.any()) failure = move(cmd.l_mm);
  reading.conditions.cmd_mm = cmd.l_mm;
  reading.conditions.from_mm = way.from_mm;
  return failure;
}

Runner::Failure Runner::read(const device::Occasion& occasion, Reading& reading,
                             store::NewReading& stored) {
  const device::TemperatureReport machine = devices_.thermometer->read(occasion);
  if (!machine.ok()) return {machine.status, "thermometer: " + machine.detail};
  const device::PoseReport seen = devices_.tracker->measure(occasion);
  if (!seen.ok()) return {seen.status, "tracker: " + seen.detail};
  reading.conditions.epoch = occasion.epoch;
  reading.conditions.time_s = occasion.time_s;
  reading.conditions.temp_degc = machine.temp_degc;
  reading.measured = seen.pose;
  stored.reading = reading;
  stored.encoder_mm = stage_.l_mm;
  if (!seen.raw_reply.empty()) stored.raw_reply = seen.raw_reply;
  return {};
}

void Runner::fail(const std::string& detail) {
  advance(Event::failed);
  detail_ = detail;
  store::add_event(connection_, course_.session.id, "faulted", detail_);
}

bool Runner::measure_point(const PlannedPoint& point) {
  for (int tries = 1;; ++tries) {
    const store::Id attempt =
        store::begin_attempt(connection_, course_.session.id, point.seq, epoch_.id);
    advance(Event::move_begun);
    const device::Occasion occasion = occasion_of(point);
    Reading reading;
    reading.set = point.set;
    reading.target = point.target;
    store::NewReading stored;
    Failure failure = drive(point, occasion, reading);
    if (!failure.any()) {
      advance(Event::in_position);
      advance(Event::settled);
      if (!asked_to_stop(2)) failure = read(occasion, reading, stored);
    }
    const bool stopped = !reading.measured && asked_to_stop(2);
    if (!failure.any() && !stopped) {
      store::finish_attempt(connection_, attempt, {stored});
      advance(Event::committed);
      stood_[point.seq] = {reading.conditions.cmd_mm, reading.conditions.from_mm};
      ++n_stored_;
      detail_ = fmt::format("{:.4f}", deviation_mm(reading));
      return true;
    }
    static_cast<void>(devices_.stage->stop());  // motion first, then the record
    const std::string what =
        stopped ? "stopped by the operator"
                : fmt::format("{}: {}", device::name_of(failure.status), failure.detail);
    store::fail_attempt(connection_, attempt, what);
    if (stopped) {
      advance(Event::stop_asked);
      return false;
    }
    if (!device::may_retry(failure.status) || tries == kMaxTries) {
      fail(fmt::format("point {}: {} (try {} of {})", point.seq, what, tries, kMaxTries));
      return false;
    }
    advance(Event::try_again);
  }
}

void Runner::learn_stored() {
  std::map<store::Id, int> seq_of;
  for (const store::Attempt& a : store::attempts(connection_, course_.session.id)) {
    if (a.status == "ok") seq_of[a.id] = a.point_seq;
  }
  for (const store::StoredReading& r :
       store::readings(connection_, course_.campaign.id, {course_.session.id})) {
    if (!r.attempt_id || !seq_of.contains(*r.attempt_id)) continue;
    const int seq = seq_of[*r.attempt_id];
    stood_[seq] = {r.data.reading.conditions.cmd_mm, r.data.reading.conditions.from_mm};
    measured_.insert_or_assign(seq, r);
  }
  for (const PlannedPoint& point : course_.plan.points) {
    if (!stood_.contains(point.seq)) open_.push_back(point);
  }
  n_before_ = static_cast<int>(stood_.size());
}

Outcome Runner::outcome() const {
  return {.state = state_,
          .session_id = course_.session.id,
          .n_points = static_cast<int>(course_.plan.points.size()),
          .n_before = n_before_,
          .n_stored = n_stored_,
          .detail = detail_};
}

Outcome Runner::walk(bool resuming, bool new_set_up) {
  learn_stored();
  if (!set_up(resuming, new_set_up)) return outcome();
  advance(Event::set_up);
  measure_open(resuming);
  if (state_ == State::stopped) {
    detail_ = "stopped by the operator";
    store::add_event(connection_, course_.session.id, "stopped", detail_);
  }
  if (state_ == State::homed || state_ == State::stored) count();
  return outcome();
}

void Runner::measure_open(bool resuming) {
  store::add_event(connection_, course_.session.id, resuming ? "resumed" : "started",
                   fmt::format("epoch {}, {} of {} points left", epoch_.number, open_.size(),
                               course_.plan.points.size()));
  Progress progress(surroundings_.quiet, surroundings_.terminal, n_before_,
                    static_cast<int>(course_.plan.points.size()));
  for (const PlannedPoint& point : open_) {
    if (asked_to_stop(1)) {
      advance(Event::stop_asked);
      break;
    }
    if (!measure_point(point)) break;
    progress.stored(std::stod(detail_));
    detail_.clear();
  }
  progress.end();
}

void Runner::count() {
  const store::SessionRow row = store::get_session(connection_, course_.session.id);
  if (row.n_ok != row.n_points) {
    return fail(fmt::format("{} of {} points are stored", row.n_ok, row.n_points));
  }
  advance(Event::counted);
  store::add_event(connection_, course_.session.id, "done", fmt::format("{} points", row.n_ok));
}

}  // namespace trammel::session
