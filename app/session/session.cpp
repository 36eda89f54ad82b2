#include "app/session/session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "app/files/stored_campaign.hpp"
#include "app/session/agreement.hpp"
#include "app/session/lock.hpp"
#include "app/session/plan_record.hpp"
#include "app/session/runner.hpp"
#include "app/session/settings.hpp"
#include "app/session/side_file.hpp"
#include "app/terminal/counted.hpp"
#include "app/terminal/text.hpp"
#include "core/measure/screen.hpp"
#include "core/mechanism/machine.hpp"
#include "store/campaign.hpp"
#include "store/machine.hpp"

namespace trammel::session {

namespace {

Correction correction_of(store::Connection& connection, const std::optional<store::Id>& job,
                         const Surroundings& surroundings) {
  if (!job) return NominalCorrection{};
  TRAMMEL_ASSERT(surroundings.correction_of);
  return surroundings.correction_of(connection, *job);
}

/// The campaign where it is there. Its mechanism is that of the devices, or it is refused.
std::optional<store::CampaignRow> campaign_of(store::Connection& connection, const Request& request,
                                              const device::Devices& devices) {
  const auto row = store::find_campaign(connection, request.campaign);
  if (!row) return std::nullopt;
  if (store::load_machine(connection, row->id) != devices.machine) {
    throw InputError({.what = "the campaign is of another mechanism",
                      .where = {.field = "campaign"},
                      .got = request.campaign,
                      .hint = "choose another campaign name"});
  }
  if (row->simulated != devices.simulated) {
    throw InputError({.what = devices.simulated ? "the campaign is real, and this stage simulated"
                                                : "the campaign is simulated, and this stage real",
                      .where = {.field = "campaign"},
                      .got = request.campaign,
                      .hint = "choose another campaign name: the two are never mixed"});
  }
  return row;
}

/// The same, made when it is not there.
store::CampaignRow campaign_for(store::Connection& connection, const Request& request,
                                const device::Devices& devices) {
  if (const auto row = campaign_of(connection, request, devices)) return *row;
  Campaign campaign;
  campaign.name = request.campaign;
  campaign.simulated = devices.simulated;
  campaign.machine = devices.machine;
  campaign.tracker = devices.sigma;
  campaign.facts = {{"stage", devices.stage->describe()},
                    {"instrument", devices.tracker->describe()}};
  campaign.facts.insert(request.facts.begin(), request.facts.end());
  store::add_campaign(connection, campaign);
  return store::require_campaign(connection, request.campaign);
}

/// What a new session follows: number and time go on from the sessions before.
Settings settings_after(const std::vector<store::SessionRow>& sessions, const Request& request,
                        const device::Devices& devices) {
  Settings settings{.approach_mm = request.plan.approach_mm,
                    .identity = devices.identity,
                    .check = check_for(request.check, devices.motion),
                    .policy = request.policy};
  for (const store::SessionRow& row : sessions) {
    if (!has_settings(row.settings_json)) continue;
    const Settings before = read_settings(row.settings_json);
    settings.ordinal = std::max(settings.ordinal, before.ordinal + 1);
    settings.start_s = std::max(settings.start_s, before.end_s + request.pause_s);
  }
  return settings;
}

/// Nothing was homed or set up anew since the last session, which was done on these devices.
bool as_before(const std::vector<store::SessionRow>& sessions, const device::Devices& devices) {
  for (auto row = sessions.rbegin(); row != sessions.rend(); ++row) {
    if (!has_settings(row->settings_json)) continue;
    return row->last_event == "done" &&
           read_settings(row->settings_json).identity == devices.identity;
  }
  return false;
}

store::NewSession new_session(const Course& course, const Request& request) {
  store::NewSession session;
  session.campaign_id = course.campaign.id;
  session.name = request.session;
  session.compensation_job = request.compensation_job;
  session.plan_name = request.plan.name;
  session.stage = request.stage;
  session.tracker = request.tracker;
  session.settings_json = settings_json(course.settings);
  for (std::size_t k = 0; k < course.plan.points.size(); ++k) {
    const PlannedPoint& p = course.plan.points[k];
    session.points.push_back({.seq = p.seq,
                              .set = p.set,
                              .target = p.target,
                              .approach = p.approach,
                              .repeat = p.repeat,
                              .reference = p.reference,
                              .role = p.group,
                              .planned_mm = course.planned_mm[k]});
  }
  return session;
}

Plan stored_plan(const store::SessionRow& row, const Settings& settings,
                 const std::vector<store::Point>& points) {
  Plan plan{row.plan_name, settings.approach_mm, {}};
  for (const store::Point& p : points) {
    plan.points.push_back({p.seq, p.target, p.set, p.approach, p.repeat, p.reference, p.role});
  }
  return plan;
}

/// A session as it was begun.
Course stored_course(store::Connection& connection, const store::CampaignRow& campaign,
                     const std::string& session) {
  Course course;
  course.campaign = campaign;
  const auto row = store::find_session(connection, campaign.id, session);
  if (!row) {
    throw NotFoundError(
        {.what = "the campaign has no such session",
         .where = {.field = "session"},
         .got = session,
         .hint = "see `trammel session status " + terminal::shell_word(campaign.name) + "`"});
  }
  if (!has_settings(row->settings_json)) {
    throw InputError({.what = "this session was not measured by a plan and cannot be resumed",
                      .where = {.field = "session"},
                      .got = session});
  }
  course.session = *row;
  course.settings = read_settings(row->settings_json);
  const auto points = store::points(connection, row->id);
  course.plan = stored_plan(*row, course.settings, points);
  for (const store::Point& p : points) course.planned_mm.push_back(p.planned_mm);
  return course;
}

bool is_done(const store::SessionRow& row) {
  return row.n_ok == row.n_points && row.last_event == "done";
}

Outcome done_before(const store::SessionRow& row) {
  return {
      .state = State::done, .session_id = row.id, .n_points = row.n_points, .n_before = row.n_ok};
}

std::shared_ptr<device::Devices> devices_of(const Course& course,
                                            const Surroundings& surroundings) {
  auto devices = std::make_shared<device::Devices>(
      surroundings.open(course.session.stage, course.session.tracker));
  if (devices->identity == course.settings.identity) return devices;
  throw InputError({.what = "the devices are not those the session began with",
                    .where = {.field = "stage"},
                    .got = course.session.stage,
                    .hint = "put the file back as it was, or start a new session"});
}

/// Nominal violations name every bad target; only a clean plan has commands to look at.
Outcome check_whole(const Request& request, device::Devices& devices, const Correction& correction,
                    std::vector<Displacements>& commands) {
  if (request.policy.base_every > 0 && !devices.tracker->sees_base()) {
    throw UsageError({.what = "this tracker has no base nests to measure again",
                      .where = {.field = "--base-every"},
                      .got = devices.tracker->describe(),
                      .expected = "t2sa:FILE, a tracker/1 file with \"base_nests\"",
                      .hint = "--reference-every N visits points of the platform instead"});
  }
  const CheckOptions options = check_for(request.check, devices.motion);
  Outcome outcome;
  outcome.n_points = static_cast<int>(request.plan.points.size());
  outcome.watch_host_s = devices.watch_host_s;
  outcome.violations = check(request.plan, devices.machine, options);
  if (outcome.violations.empty()) {
    commands = planned_commands(request.plan, devices.machine, correction);
    outcome.violations = check(request.plan, devices.machine, options, commands);
  }
  if (outcome.violations.empty()) {
    outcome.plan_sha256 = plan_sha256(request.plan, devices.machine);
    devices.clock->start(request.plan, 0);
    outcome.estimated_s = devices.clock->end_s();
    if (!devices.virtual_time) {
      outcome.missing = missing_record(request.plan_check, request.plan, devices.machine, options);
    }
  }
  outcome.state =
      *next(State::planned, outcome.refused() ? Event::check_failed : Event::check_passed);
  if (!outcome.violations.empty()) outcome.detail = "the plan is not safe; nothing has moved";
  if (!outcome.missing.empty()) outcome.detail = outcome.missing.front();
  return outcome;
}

/// What an earlier run could not store is stored first.
void take_in(store::Connection& connection, const store::CampaignRow& campaign) {
  const Recovery recovery = recover(connection, campaign);
  if (recovery.problems.empty()) return;
  throw InputError({.what = "a reading that was kept aside cannot be taken in",
                    .got = recovery.problems.front(),
                    .hint = "see `trammel session recover " + terminal::shell_word(campaign.name) +
                            "`; move the file away to go on without it"});
}

/// Whoever holds the campaign's lock knows that no other runner is alive: what is open was left by
/// one that died, in the session itself or while it looked at its reference points.
void close_what_is_open(store::Connection& connection, store::Id campaign) {
  for (const store::SessionName& session : store::session_names(connection, campaign)) {
    store::hold_clock(connection, session.id);
    store::interrupt_open_attempts(connection, session.id, "the runner ended before it was closed");
  }
}

struct Start {
  double time_s = 0;
  double back_s = 0;  // by so much the computer's clock stands before the last stored reading
};

/// Where the plan's own time begins: as it was to, but other sessions that were measured beyond its
/// next point put it off, so that no reading is earlier than the one before. (Reference points of a
/// resume have the time of the next point.)
double virtual_start_s(store::Connection& connection, const Course& course, device::Clock& clock) {
  const double start_s = course.settings.start_s;
  double last_s = start_s, own_s = start_s, next_s = INFINITY;
  for (const store::StoredReading& r : store::readings(connection, course.campaign.id)) {
    const double time_s = r.data.reading.conditions.time_s.value_or(start_s);
    last_s = std::max(last_s, time_s);
    if (r.session_id == course.session.id) own_s = std::max(own_s, time_s);
  }
  clock.start(course.plan, start_s);
  for (const PlannedPoint& point : course.plan.points) {
    if (clock.time_s(point) > own_s) next_s = std::min(next_s, clock.time_s(point));
  }
  return last_s > next_s ? start_s + (last_s - own_s) : start_s;
}

/// The plan's own time goes on where it ended; that of the world has passed by itself, but never
/// back before the last stored reading.
Start start_of(store::Connection& connection, const Course& course,
               const device::Devices& devices) {
  if (devices.virtual_time) return {virtual_start_s(connection, course, *devices.clock)};
  const double age_s = store::campaign_age_s(connection, course.campaign.id);
  double last_s = age_s;
  for (const store::StoredReading& r : store::readings(connection, course.campaign.id))
    last_s = std::max(last_s, r.data.reading.conditions.time_s.value_or(last_s));
  return {last_s, last_s - age_s};
}

void note_jump(store::Connection& connection, store::Id session, const Start& start) {
  if (start.back_s <= 0) return;
  store::add_event(connection, session, "clock",
                   fmt::format("the computer's clock stands {:.3f} s before the last stored "
                               "reading: time goes on from there",
                               start.back_s));
}

/// Nothing is measured on top of readings that the screen refuses.
void require_sound_before(store::Connection& connection, const store::CampaignRow& campaign) {
  const CampaignFile stored = stored_campaign(connection, campaign);
  require_sound(stored.campaign, screened(stored),
                "see `trammel campaign check " + terminal::shell_word(campaign.name) + "`");
}

/// The stored plan, on the stage as it is now.
Outcome checked_again(const Course& course, const device::Devices& devices) {
  const store::SessionRow& row = course.session;
  Outcome outcome{.state = State::planned,
                  .session_id = row.id,
                  .n_points = row.n_points,
                  .n_before = row.n_ok,
                  .watch_host_s = devices.watch_host_s};
  outcome.violations = check(course.plan, devices.machine,
                             check_for(course.settings.check, devices.motion), course.planned_mm);
  outcome.state =
      *next(State::planned, outcome.refused() ? Event::check_failed : Event::check_passed);
  if (outcome.refused()) outcome.detail = "the plan is not safe; nothing has moved";
  outcome.estimated_s = (course.settings.end_s - course.settings.start_s) *
                        (row.n_points - row.n_ok) / std::max(1, row.n_points);
  outcome.plan_sha256 = course.settings.plan_sha256;
  return outcome;
}

}  // namespace

CheckOptions check_for(CheckOptions check, const device::Motion& motion) {
  if (motion.speed_mm_s > 0) check.speed_mm_s = motion.speed_mm_s;
  if (motion.max_speed_mm_s > 0) {
    check.max_speed_mm_s = std::min(check.max_speed_mm_s, motion.max_speed_mm_s);
  }
  return check;
}

void really_sleep(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

ExitCode Outcome::exit_code() const {
  if (refused()) return ExitCode::safety_stop;
  if (state == State::faulted) return fault;
  return state == State::stopped ? ExitCode::interrupted : ExitCode::ok;
}

Outcome dry_run(const Request& request, const Correction& correction,
                const Surroundings& surroundings, store::Connection* connection) {
  validate(request.policy);
  device::Devices devices = surroundings.open(request.stage, request.tracker);
  if (connection != nullptr) static_cast<void>(campaign_of(*connection, request, devices));
  std::vector<Displacements> commands;
  return check_whole(request, devices, correction, commands);
}

Outcome run(store::Connection& connection, const Request& request,
            const Surroundings& surroundings) {
  if (request.session.empty()) throw UsageError({.what = "a session needs a name"});
  validate(request.policy);
  std::optional<ControllerLock> alone;  // until the devices are let go
  const auto devices =
      std::make_shared<device::Devices>(surroundings.open(request.stage, request.tracker));
  Course course;
  course.plan = request.plan;
  course.correction = correction_of(connection, request.compensation_job, surroundings);
  const Outcome looked = check_whole(request, *devices, course.correction, course.planned_mm);
  if (looked.refused()) return looked;

  course.campaign = campaign_for(connection, request, *devices);
  const CampaignLock lock(connection.file(), course.campaign.uuid);
  if (!devices->controller.empty()) alone.emplace(devices->controller);
  take_in(connection, course.campaign);
  const SideRoom room(side_file(connection.file(), course.campaign.uuid));
  require_sound_before(connection, course.campaign);
  const auto sessions = store::list_sessions(connection, course.campaign.id);
  course.settings = settings_after(sessions, request, *devices);
  course.settings.plan_sha256 = looked.plan_sha256;
  const Start start = start_of(connection, course, *devices);
  course.settings.start_s = start.time_s;
  devices->clock->start(course.plan, course.settings.start_s);
  course.settings.end_s = devices->clock->end_s();
  const bool new_set_up = request.new_set_up || !as_before(sessions, *devices);
  const store::Id id = store::create_session(connection, new_session(course, request));
  course.session = store::get_session(connection, id);
  note_jump(connection, id, start);
  for (const std::string& what : request.confirmed) {
    store::add_event(connection, id, "confirmed", what);
  }
  store::add_event(
      connection, id, "checked",
      fmt::format("{}, plan {}, estimated {}", terminal::counted(looked.n_points, "point"),
                  looked.plan_sha256, terminal::clock_text(looked.estimated_s)));
  Outcome outcome = Runner(connection, devices, course, surroundings).walk(false, new_set_up);
  outcome.estimated_s = looked.estimated_s;
  outcome.plan_sha256 = looked.plan_sha256;
  return outcome;
}

Outcome dry_resume(store::Connection& connection, const std::string& campaign,
                   const std::string& session, const Surroundings& surroundings) {
  const Course course =
      stored_course(connection, store::require_campaign(connection, campaign), session);
  if (is_done(course.session)) return done_before(course.session);
  return checked_again(course, *devices_of(course, surroundings));
}

Outcome resume(store::Connection& connection, const std::string& campaign,
               const std::string& session, const Surroundings& surroundings) {
  const store::CampaignRow owner = store::require_campaign(connection, campaign);
  const CampaignLock lock(connection.file(), owner.uuid);
  take_in(connection, owner);
  require_sound_before(connection, owner);
  Course course = stored_course(connection, owner, session);
  if (is_done(course.session)) return done_before(course.session);
  std::optional<ControllerLock> alone;  // until the devices are let go
  const auto devices = devices_of(course, surroundings);
  if (!devices->controller.empty()) alone.emplace(devices->controller);
  const Outcome looked = checked_again(course, *devices);
  if (looked.refused()) return looked;
  course.correction = correction_of(connection, course.session.compensation_job, surroundings);
  const Start start = start_of(connection, course, *devices);
  devices->clock->start(course.plan, start.time_s);
  close_what_is_open(connection, owner.id);
  note_jump(connection, course.session.id, start);
  const SideRoom room(side_file(connection.file(), owner.uuid));
  Outcome outcome = Runner(connection, devices, course, surroundings).walk(true, false);
  outcome.estimated_s = looked.estimated_s;
  outcome.plan_sha256 = looked.plan_sha256;
  return outcome;
}

Outcome run_or_resume(store::Connection& connection, const Request& request,
                      const Surroundings& surroundings) {
  if (const auto campaign = store::find_campaign(connection, request.campaign)) {
    if (const auto stored = store::find_session(connection, campaign->id, request.session)) {
      require_same(connection, *stored, request);
      return resume(connection, request.campaign, request.session, surroundings);
    }
  }
  return run(connection, request, surroundings);
}

}  // namespace trammel::session
