#include "app/session/runner.hpp"
#include "app/terminal/counted.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/error.hpp"
#include "core/mechanism/machine_solver.hpp"
#include "store/open.hpp"

namespace trammel::session {

namespace {

constexpr double kPausedPollS = 0.05;

Displacements home_of(const Machine& machine) {
  const InverseResult home = MachineSolver(machine).drives(machine.home);
  if (!home.ok()) throw InputError({.what = "the home pose is out of reach"});
  return home.l_mm;
}

}  // namespace

InverseResult command_for(const Correction& correction, const Machine& machine, const Move& move) {
  return commanded(correction, machine, move);
}

std::vector<Displacements> planned_commands(const Plan& plan, const Machine& machine,
                                            const Correction& correction) {
  std::vector<Displacements> commands;
  Displacements at = home_of(machine), at_from = at;
  for (const PlannedPoint& point : plan.points) {
    const Move move{.target = point.target, .from_mm = at, .approach = point.approach};
    const InverseResult cmd = command_for(correction, machine, move);
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

Runner::Runner(store::Connection& connection, std::shared_ptr<device::Devices> devices,
               const Course& course, const Surroundings& surroundings)
    : connection_(connection),
      place_(connection),
      devices_(std::move(devices)),
      course_(course),
      surroundings_(surroundings),
      wishes_(connection, course.session.id, surroundings.stop_signals),
      hands_(devices_, course.settings.check, surroundings.deadlines,
             [this] {
               try {
                 return wishes_.now() == Wish::stop_now;
               } catch (const Error&) {
                 return false;  // a database that fails is met where something must be stored
               }
             }),
      gate_(pose_gate(
          course.settings.policy, course.plan, devices_->sigma,
          devices_->virtual_time ? std::nullopt : std::optional(devices_->machine.home))) {}

void Runner::advance(Event event) {
  const std::optional<State> to = next(state_, event);
  TRAMMEL_ASSERT(to.has_value());
  state_ = *to;
  const std::chrono::duration<double> since = std::chrono::steady_clock::now() - try_began_;
  if (!trail_.empty()) trail_ += fmt::format(" > {} {:.3f} s", name_of(state_), since.count());
}

void Runner::note(const char* kind, const std::string& detail) {
  store::add_event(connection_, course_.session.id, kind, detail);
}

void Runner::fail(const std::string& detail, ExitCode code) {
  if (state_ != State::faulted) advance(Event::failed);
  detail_ = detail;
  fault_ = code;
  note("faulted", detail_);
}

/// A failure that nothing more is tried against.
void Runner::end_with(const Failure& failure, const std::string& where) {
  if (failure.cause == Failure::Cause::cancelled) {
    if (state_ != State::stopped) advance(Event::stop_asked);
    return;
  }
  fail(where + ": " + failure.words(), failure.exit_code());
}

bool Runner::asked_to_stop() { return wishes_.now() >= Wish::stop; }

void Runner::learn_stored() {
  std::map<store::Id, int> seq_of;
  for (const store::Attempt& a : store::attempts(connection_, course_.session.id)) {
    if (a.status == "ok") seq_of[a.id] = a.point_seq;
  }
  std::set<int> excluded;
  for (const store::Exclusion& e : store::exclusions(connection_, course_.campaign.id)) {
    excluded.insert(e.seq);
  }
  for (const store::StoredReading& r :
       store::readings(connection_, course_.campaign.id, {course_.session.id})) {
    if (!r.attempt_id || !seq_of.contains(*r.attempt_id)) continue;
    const int seq = seq_of[*r.attempt_id];
    stood_[seq] = {r.data.reading.conditions.cmd_mm, r.data.reading.conditions.from_mm};
    if (!excluded.contains(r.data.reading.seq)) measured_.insert_or_assign(seq, r);
  }
  for (const auto& [seq, stored] : measured_) learn_step(seq);
  open_.clear();
  for (const PlannedPoint& point : course_.plan.points) {
    if (!stood_.contains(point.seq)) open_.push_back(point);
  }
}

Outcome Runner::outcome() const {
  return {.state = state_,
          .session_id = course_.session.id,
          .n_points = static_cast<int>(course_.plan.points.size()),
          .n_before = n_before_,
          .n_stored = n_stored_,
          .detail = detail_,
          .fault = fault_};
}

Outcome Runner::walk(bool resuming, bool new_set_up) {
  try {
    return walk_on(resuming, new_set_up);
  } catch (const Error& error) {
    static_cast<void>(hands_.stop());  // motion first, then the record
    trail_.clear();
    try {
      if (next(state_, Event::failed)) fail(error.what(), error.code());
    } catch (const Error&) {  // the database takes nothing: the first error is the one that is said
    }
    if (progress_) progress_->end();
    throw;
  } catch (...) {
    static_cast<void>(hands_.stop());
    throw;
  }
}

Outcome Runner::walk_on(bool resuming, bool new_set_up) {
  learn_stored();
  n_before_ = static_cast<int>(stood_.size());
  progress_.emplace(surroundings_.quiet, surroundings_.terminal, n_before_,
                    static_cast<int>(course_.plan.points.size()));
  if (devices_->watch_host_s) progress_->say(device::watch_text(*devices_->watch_host_s));
  while (set_up(resuming, new_set_up)) {
    advance(Event::set_up);
    store::checkpoint(connection_);  // the plan
    measure_open(resuming);
    if (state_ != State::paused || !wait_while_paused()) break;
    resuming = true;
    learn_stored();
  }
  progress_->end();
  if (state_ == State::stopped) {
    if (detail_.empty()) detail_ = "stopped by " + surroundings_.stopped_by();
    note("stopped", detail_);
  }
  if (state_ == State::homed || state_ == State::stored) count();
  return outcome();
}

void Runner::measure_open(bool resuming) {
  std::string begins = fmt::format("epoch {}, {} of {} left", epoch_.number, open_.size(),
                                   terminal::counted(course_.plan.points.size(), "point"));
  if (devices_->watch_host_s) begins += "; " + device::watch_text(*devices_->watch_host_s);
  note(resuming ? "resumed" : "started", begins);
  for (const PlannedPoint& point : open_) {
    const Wish wish = wishes_.now();
    if (wish >= Wish::stop) return advance(Event::stop_asked);
    if (wish == Wish::pause) {
      advance(Event::pause_asked);
      return note("paused", "by the operator");
    }
    for (bool measured = false; !measured;) {
      if (!conditions_hold(point)) return;
      measured = measure_point(point);
      if (!measured && stepped_.empty()) return;
    }
  }
  look_at_base_once_more();
}

/// True: go on, by way of a set-up.
bool Runner::wait_while_paused() {
  if (wishes_.now() != Wish::go_on) {
    wishes_.taken();
    progress_->say("paused; go on with `trammel session resume`");
  }
  for (;;) {
    const Wish wish = wishes_.now();
    if (wish >= Wish::stop) {
      advance(Event::stop_asked);
      return false;
    }
    if (wish == Wish::go_on) {
      wishes_.taken();
      advance(Event::resumed);
      return true;
    }
    surroundings_.sleep(kPausedPollS);
  }
}

/// Points of the session that are ok for whoever opens the database by its name now. Throws
/// StoreError where that is not the database of this runner, to the last reading.
int Runner::found_by_name() const {
  store::Connection fresh = store::open(connection_.file(), store::Access::read_only);
  const auto campaign = store::find_campaign(fresh, course_.campaign.uuid);
  const auto session =
      campaign ? store::find_session(fresh, campaign->id, course_.session.name) : std::nullopt;
  if (!session || store::chain_head(fresh, campaign->id) !=
                      store::chain_head(connection_, course_.campaign.id)) {
    throw StoreError({.what = "the database does not hold the readings of this session",
                      .where = {.file = connection_.file().string()},
                      .got = session ? "other readings" : "no such session",
                      .expected = "nobody restores or overwrites it while it is written",
                      .hint = "run `trammel db verify`, and see what happened to the file"});
  }
  return session->n_ok;
}

/// Done is what another process would find.
void Runner::count() {
  place_.require_same();
  store::checkpoint(connection_);
  const int n_ok = found_by_name();
  const int n_points = static_cast<int>(course_.plan.points.size());
  if (n_ok != n_points) {
    return fail(fmt::format("{} of {} stored", n_ok, terminal::counted(n_points, "point")),
                ExitCode::storage);
  }
  advance(Event::counted);
  const int n_excluded = n_ok - static_cast<int>(measured_.size());
  note("done", fmt::format("{}{}", terminal::counted(n_ok, "point"),
                           n_excluded > 0 ? fmt::format(", {} of them excluded", n_excluded) : ""));
}

}  // namespace trammel::session
