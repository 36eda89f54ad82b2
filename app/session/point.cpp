// One point: the way to it, the reading, what is tried again and what is not.

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "app/session/runner.hpp"
#include "app/session/side_file.hpp"
#include "app/terminal/text.hpp"
#include "core/measure/gross.hpp"
#include "core/mechanism/inverse.hpp"
#include "core/units.hpp"

namespace trammel::session {

namespace {

using Cause = Failure::Cause;

constexpr std::uint64_t kReadingsPerSession = 10'000'000;
constexpr double kBeamPollS = 1;
// Between two looks at the database by its name. A point adds some 10 pages to the log, which
// SQLite itself would leave there up to 1000.
constexpr int kPointsPerCheckpoint = 16;

constexpr double kFollowingMm = 0.5;  // of a stage that does not say

/// Measured less target; 0 in what is not measured, which a reading holds as 0.
Eigen::Vector3d deviation(const Reading& reading, const Coordinates& measured) {
  Eigen::Vector3d off = reading.measured->vector() - reading.target.vector();
  for (int c = 0; c < 3; ++c) {
    if (!measured[static_cast<std::size_t>(c)]) off[c] = 0;
  }
  return off;
}
double deviation_mm(const Reading& reading, const Coordinates& measured) {
  return deviation(reading, measured).head<2>().norm();
}

double way_mm(const Pose& a, const Pose& b) { return std::hypot(b.x_mm - a.x_mm, b.y_mm - a.y_mm); }

using Measured = std::map<int, store::StoredReading>;

/// The stored reading nearest to a target, of the points before `before`; none where none is
/// stored.
const Reading* nearest(const Measured& measured, const Pose& target,
                       int before = std::numeric_limits<int>::max()) {
  const Reading* best = nullptr;
  for (const auto& [seq, stored] : measured) {
    const Reading& reading = stored.data.reading;
    if (seq >= before) break;
    if (best == nullptr || way_mm(reading.target, target) < way_mm(best->target, target)) {
      best = &reading;
    }
  }
  return best;
}

/// How much two deviations differ beyond what their distance explains.
double step_mm(const Reading& a, const Reading& b, const Coordinates& measured) {
  const double apart_mm = (deviation(a, measured) - deviation(b, measured)).head<2>().norm();
  return std::max(0.0, apart_mm - kGateSlope * way_mm(a.target, b.target));
}

}  // namespace

Standing Runner::start_of(const PlannedPoint& point) const {
  const auto before = stood_.find(point.seq - 1);
  return before == stood_.end() ? hands_.home_place() : before->second;
}

/// Where the plan has the stage before this point, however it came here: a repeated try or a resume
/// approaches from the same side as an undisturbed walk.
Failure Runner::stand_before(const PlannedPoint& point) {
  const Standing start = start_of(point);
  const Standing& now = hands_.place();
  if (hands_.on_course() && now.l_mm == start.l_mm && now.from_mm == start.from_mm) return {};
  if (start.l_mm == hands_.home_place().l_mm) return hands_.home();
  const Failure failure = hands_.move(start.from_mm);
  return failure.any() ? failure : hands_.move(start.l_mm);
}

device::Occasion Runner::occasion_of(const PlannedPoint& point) {
  return {.reading = static_cast<std::uint64_t>(course_.settings.ordinal) * kReadingsPerSession +
                     static_cast<std::uint64_t>(point.seq),
          .time_s = devices_->clock->time_s(point),
          .epoch = epoch_.number};
}

Failure Runner::drive(const PlannedPoint& point, const device::Occasion& occasion,
                      Reading& reading) {
  Failure failure = stand_before(point);
  if (failure.any()) return failure;
  double temp_degc = 0;
  failure = hands_.temperature(occasion, temp_degc);
  if (failure.any()) return failure;
  const Standing at = hands_.place();
  const InverseResult cmd = command_for(course_.correction, devices_->machine,
                                        {.target = point.target,
                                         .from_mm = at.l_mm,
                                         .approach = point.approach,
                                         .epoch = epoch_.number,
                                         .time_s = occasion.time_s,
                                         .temp_degc = temp_degc});
  const Displacements& planned = course_.planned_mm[static_cast<std::size_t>(point.seq) - 1];
  if (!cmd.ok() || !((cmd.l_mm - planned).cwiseAbs().maxCoeff() <= kMaxFromPlannedMm)) {
    return unsafe(
        fmt::format("the command is more than {} mm from what was checked", kMaxFromPlannedMm));
  }
  const PlannedMove way = planned_move(course_.plan, point, cmd.l_mm, at.l_mm, at.from_mm);
  if (way.pre_position) failure = hands_.move(way.pre_mm);
  if (!failure.any()) failure = hands_.move(cmd.l_mm);
  reading.conditions.cmd_mm = cmd.l_mm;
  reading.conditions.from_mm = way.from_mm;
  return failure;
}

/// The beam is asked for before and after: a reading during which it was lost is none.
Failure Runner::read(const device::Occasion& occasion, store::NewReading& stored) {
  Reading& reading = stored.reading;
  double temp_degc = 0;
  device::PoseReport seen;
  Failure failure = hands_.temperature(occasion, temp_degc);
  if (!failure.any()) failure = hands_.measure(occasion, seen);
  if (!failure.any()) failure = hands_.beam();
  if (failure.any()) return failure;
  reading.conditions.epoch = occasion.epoch;
  reading.conditions.time_s = occasion.time_s;
  reading.conditions.temp_degc = temp_degc;
  reading.measured = seen.pose;
  stored.encoder_mm = hands_.encoder_mm();
  if (!seen.raw_reply.empty()) stored.raw_reply = seen.raw_reply;
  if (!seen.detail.empty()) note("clock", seen.detail);
  return judge(stored);
}

/// Commanded against measured. A robot that is not where it was sent is not sent any further, and a
/// reading that belongs to another pose is not stored.
Failure Runner::judge(const store::NewReading& stored) const {
  const double following_mm =
      devices_->motion.following_mm > 0 ? devices_->motion.following_mm : kFollowingMm;
  int worst = 0;
  const double off_drive_mm =
      (*stored.encoder_mm - stored.reading.conditions.cmd_mm).cwiseAbs().maxCoeff(&worst);
  if (!(off_drive_mm <= following_mm)) {
    return unsafe(fmt::format("{} stands {:.3f} mm from its command (gate {:g} mm)",
                              drive_name(devices_->machine, worst), off_drive_mm, following_mm));
  }
  const Pose& target = stored.reading.target;
  const Reading* near = nearest(measured_, target);
  const Coordinates& measured = devices_->machine.measured;
  Eigen::Vector3d off = deviation(stored.reading, measured);
  double xy_mm = gate_.first_xy_mm, phi_rad = gate_.first_phi_rad;
  const double least_mm = devices_->virtual_time ? kLashMm : 0;
  const double least_rad = devices_->virtual_time ? kLashRad : 0;
  if (near != nullptr) {
    const Eigen::Vector3d shared = deviation(*near, measured);
    if (!gate_.stated_xy) {
      off.head<2>() -= shared.head<2>();
      xy_mm = std::max(gate_.xy_mm, least_mm) + kGateSlope * way_mm(near->target, target);
      xy_mm = std::min(xy_mm, kMostGateMm);
    }
    if (!gate_.stated_phi) {
      off[2] -= shared[2];
      phi_rad = std::max(gate_.phi_rad, least_rad) +
                kGateSlope * std::abs(target.phi_rad - near->target.phi_rad);
    }
  }
  const char* where = near == nullptr ? "its target" : "where the points beside it are";
  const double off_mm = off.head<2>().norm();
  if (!(off_mm <= xy_mm)) {
    return beyond_gate(
        stored,
        fmt::format("the platform was measured {:.3f} mm from {} (gate {:.3g} mm; --gate-mm states "
                    "another)",
                    off_mm, gate_.stated_xy ? "its target" : where, xy_mm));
  }
  if (!(std::abs(off[2]) <= phi_rad)) {
    return beyond_gate(
        stored,
        fmt::format("the platform was measured turned by {:.3f} deg from {} (gate {:.3g} deg; "
                    "--gate-deg states another)",
                    deg_from_rad(off[2]), gate_.stated_phi ? "its target" : where,
                    deg_from_rad(phi_rad)));
  }
  return {};
}

/// The readings of this session.
Campaign Runner::so_far() const {
  Campaign campaign;
  campaign.name = course_.campaign.name;
  campaign.machine = devices_->machine;
  campaign.tracker = devices_->sigma;
  for (const auto& [seq, stored] : measured_) campaign.readings.push_back(stored.data.reading);
  return campaign;
}

/// A reading beyond its gate: a mistake that explains it and all before it is named.
Failure Runner::beyond_gate(const store::NewReading& stored, const std::string& how) const {
  Campaign campaign = so_far();
  campaign.readings.push_back(stored.reading);
  std::vector<Suspicion> found = gross_mistakes(campaign);
  if (found.empty()) found = gross_mistakes_of_few(campaign);
  if (found.empty()) return {Cause::elsewhere, device::Status::fault, how};
  return {Cause::gross, device::Status::fault, how + "; the screen: " + gross_in_words(found)};
}

/// The screen on what is stored of this session, at 6, 12, 24, … points and after the last.
bool Runner::sound_so_far() {
  const auto n = static_cast<int>(measured_.size());
  const bool due =
      n % kFewestScreened == 0 && std::has_single_bit(static_cast<unsigned>(n / kFewestScreened));
  if (n < kFewestScreened || (!due && stood_.size() != course_.plan.points.size())) return true;
  const std::string names = gross_in_words(screened(so_far()));
  if (names.empty()) return true;
  static_cast<void>(hands_.stop());  // motion first, then the record
  std::string why = "the screen refuses the readings of this session: " + names;
  why += exclude(course_.plan.points, why);
  fail(why, ExitCode::invalid_data);
  return false;
}

/// A deviation that differs from that of the nearest stored point as none before it did: a tracker
/// or a base that was knocked, unless the reference points and base nests are where they were. What
/// is simulated can't be knocked.
Failure Runner::look_for_step(const store::NewReading& stored) const {
  constexpr std::size_t kFewest = 6;  // points, before it is known how deviations differ
  constexpr double kLeastMm = 0.3, kTimes = 3, kSigmas = 6;
  if (devices_->virtual_time || measured_.size() < kFewest) return {};
  const double noise_mm = devices_->sigma ? kSigmas * std::sqrt(2.0) * devices_->sigma->xy_mm : 0.0;
  const double limit_mm =
      std::max({kLeastMm, course_.settings.policy.drift_mm, kTimes * usual_mm_, noise_mm});
  const double by_mm = step_mm(stored.reading, *nearest(measured_, stored.reading.target),
                               devices_->machine.measured);
  if (by_mm <= limit_mm) return {};
  return {Cause::stepped, device::Status::unstable,
          fmt::format("its deviation is a step of {:.3f} mm from that of the point nearest to it "
                      "({:.3f} mm are usual)",
                      by_mm, usual_mm_)};
}

/// How a stored point differs from the nearest one before it.
void Runner::learn_step(int seq) {
  const Reading& reading = measured_.at(seq).data.reading;
  const Reading* near = nearest(measured_, reading.target, seq);
  if (near != nullptr)
    usual_mm_ = std::max(usual_mm_, step_mm(reading, *near, devices_->machine.measured));
}

Failure Runner::try_point(const PlannedPoint& point, store::NewReading& stored) {
  const device::Occasion occasion = occasion_of(point);
  stored.reading.set = point.set;
  stored.reading.target = point.target;
  Failure failure = drive(point, occasion, stored.reading);
  if (failure.any()) return failure;
  advance(Event::in_position);
  failure = hands_.beam();
  if (failure.any()) return failure;
  advance(Event::settled);
  if (wishes_.now() == Wish::stop_now) return {Cause::cancelled, device::Status::fault, ""};
  failure = read(occasion, stored);
  if (failure.any() || believed_ == point.seq) return failure;
  return look_for_step(stored);
}

/// Readings and attempt = ok in one transaction, in the database that was opened: only then is it
/// stored. Returns the reading's number.
int Runner::commit(const Task& task, store::Id attempt, const store::NewReading& reading) {
  const std::string walk = task.walks ? trail_ + " > " + name_of(State::stored) : "";
  try {
    const int seq = store::finish_attempt(connection_, attempt, {reading}, walk).front();
    place_.require_same();
    return seq;
  } catch (const StoreError& error) {
    static_cast<void>(hands_.stop());  // motion first, then the record
    const auto file = side_file(connection_.file(), course_.campaign.uuid);
    ErrorText text = error.text();
    try {
      keep_aside(file, {.campaign_uuid = course_.campaign.uuid,
                        .session = task.session_name,
                        .point_seq = task.seq,
                        .epoch = task.epoch.number,
                        .reading = reading});
      text.hint += fmt::format(
          "{}the reading of point {} is kept in {}: `trammel session recover {}` takes it in",
          text.hint.empty() ? "" : "; ", task.seq, file.string(),
          terminal::shell_word(course_.campaign.name));
    } catch (const StoreError& second) {
      text.what += fmt::format("; the reading of point {} could not be kept aside either ({})",
                               task.seq, second.what());
    }
    throw StoreError(text);
  }
}

Failure Runner::try_hard(const Task& task, store::NewReading& reading) {
  std::map<device::Status, int> failures;
  for (int tries = 1;; ++tries) {
    const store::Id attempt =
        store::begin_attempt(connection_, task.session, task.seq, task.epoch.id);
    if (task.walks) {
      try_began_ = std::chrono::steady_clock::now();
      trail_ = fmt::format("point {}, try {}: {}", task.seq, tries, name_of(state_));
      advance(Event::move_begun);
    }
    reading = {};
    Failure failure = task.once(reading);
    if (!failure.any()) {
      reading.reading.seq = commit(task, attempt, reading);
      if (task.walks) advance(Event::committed);
      trail_.clear();
      return {};
    }
    const Failure stopped = hands_.stop();  // motion first, then the record
    if (stopped.any()) {
      failure.detail = failure.words() + "; " + stopped.words();
      failure.cause = Cause::hung;
    }
    const int most = tries_for(failure.status);
    const bool again = failure.cause == Cause::device && ++failures[failure.status] < most;
    const bool cancelled = failure.cause == Cause::cancelled;
    const bool stepped = failure.cause == Cause::stepped;
    if (task.walks) {
      advance(again || stepped ? Event::try_again : cancelled ? Event::stop_asked : Event::failed);
    }
    store::fail_attempt(connection_, attempt, failure.words(), trail_);
    trail_.clear();
    if (again) {
      progress_->say(fmt::format("point {}: {}; tried again", task.seq, failure.words()));
      const Failure waited = wait_for_another_try(failure);
      if (!waited.any()) continue;
      return waited;
    }
    if (failure.cause == Cause::device) {
      failure.detail += fmt::format(" (try {} of {})", failures[failure.status], most);
    }
    return failure;
  }
}

/// The reflector is given time to be found again.
Failure Runner::wait_for_another_try(const Failure& failure) {
  const Policy& policy = course_.settings.policy;
  const bool lost = failure.status == device::Status::beam_broken;
  const double patience_s = lost ? policy.beam_patience_s : policy.retry_wait_s;
  for (double waited_s = 0; waited_s < patience_s; waited_s += kBeamPollS) {
    if (asked_to_stop()) return {Cause::cancelled, device::Status::fault, ""};
    if (lost) {
      const Failure beam = hands_.beam();
      if (!beam.any()) return {};
      if (beam.cause != Cause::device) return beam;
    }
    pass(std::min(kBeamPollS, patience_s - waited_s));
  }
  return {};
}

/// What is stored and in doubt now is left out, and says so: later jobs use none of it. Returns how
/// that is reported, in words.
std::string Runner::exclude(const std::vector<PlannedPoint>& points, const std::string& why) {
  constexpr std::size_t kMostWords = 900;  // of the 1000 characters that a reason may have
  std::string seqs;
  for (const PlannedPoint& point : points) {
    const auto stored = measured_.find(point.seq);
    if (stored == measured_.end()) continue;
    const int seq = stored->second.data.reading.seq;
    store::exclude_reading(connection_, course_.campaign.id, seq,
                           "by the session: " + why.substr(0, kMostWords));
    seqs += (seqs.empty() ? "" : ", ") + std::to_string(seq);
    measured_.erase(stored);
  }
  if (seqs.empty()) return "";
  return "; what is stored and in doubt is excluded: readings " + seqs;
}

/// A pose that is not where it was sent contradicts what is stored: a mistake that explains it
/// explains all; and while there is but one reading, judged by its target alone, nothing tells
/// which of the two is right, nor whether it was of now where answers come too late or are old.
Failure Runner::with_those_in_doubt(Failure failure) {
  const bool late = failure.cause == Cause::device && failure.status == device::Status::timeout;
  const bool one = measured_.size() == 1 && (late || failure.cause == Cause::elsewhere);
  if (one || failure.cause == Cause::gross) {
    failure.detail += exclude(course_.plan.points, failure.words());
  }
  return failure;
}

bool Runner::measure_point(const PlannedPoint& point) {
  const Task task{.session = course_.session.id,
                  .session_name = course_.session.name,
                  .seq = point.seq,
                  .epoch = epoch_,
                  .walks = true,
                  .once = [&](store::NewReading& reading) { return try_point(point, reading); }};
  store::NewReading stored;
  const Failure failure = try_hard(task, stored);
  if (failure.cause == Cause::stepped) {
    stepped_ = fmt::format("point {}: {}", point.seq, failure.words());
    progress_->say(stepped_ + "; the set-up is looked at");
    return false;
  }
  if (failure.any()) {
    end_with(with_those_in_doubt(failure), fmt::format("point {}", point.seq));
    return false;
  }
  stood_[point.seq] = {stored.reading.conditions.cmd_mm, stored.reading.conditions.from_mm};
  measured_.insert_or_assign(
      point.seq,
      store::StoredReading{.session_id = task.session, .attempt_id = std::nullopt, .data = stored});
  learn_step(point.seq);
  ++n_stored_;
  ++since_visit_;
  ++since_base_;
  if (n_stored_ % kPointsPerCheckpoint == 0) {
    store::checkpoint(connection_);
    static_cast<void>(found_by_name());
  }
  if (surroundings_.stored) surroundings_.stored(n_stored_);
  progress_->stored(deviation_mm(stored.reading, devices_->machine.measured));
  return sound_so_far();
}

}  // namespace trammel::session
