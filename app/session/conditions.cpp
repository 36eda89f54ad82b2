// Bad conditions are waited out: temperature out of its band, reference points that have drifted.

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "app/session/base_check.hpp"
#include "app/session/runner.hpp"

namespace trammel::session {

namespace {

constexpr double kSliceS = 0.2;

/// Empty: good. Once suspended, it is good again only well inside.
std::string out_of_band(double temp_degc, const Policy& policy, bool suspended) {
  const double inside_k = suspended ? policy.hysteresis_k : 0;
  if (policy.low_degc && !(temp_degc >= *policy.low_degc + inside_k)) {
    return fmt::format("{:.2f} degC, at least {:.2f}", temp_degc, *policy.low_degc + inside_k);
  }
  if (policy.high_degc && !(temp_degc <= *policy.high_degc - inside_k)) {
    return fmt::format("{:.2f} degC, at most {:.2f}", temp_degc, *policy.high_degc - inside_k);
  }
  return "";
}

}  // namespace

/// A simulated room does not change by waiting: nobody waits for it. Who is asked for `until`, or
/// more, waits no longer.
void Runner::pass(double seconds, Wish until) {
  if (devices_->virtual_time) return;
  for (double left = seconds; left > 0 && wishes_.now() < until; left -= kSliceS) {
    surroundings_.sleep(std::min(kSliceS, left));
  }
}

Runner::Found Runner::look_at_conditions(const PlannedPoint& point, bool suspended) {
  const Policy& policy = course_.settings.policy;
  if (policy.low_degc || policy.high_degc) {
    double temp_degc = 0;
    const Failure failure = hands_.temperature(occasion_of(point), temp_degc);
    if (failure.any()) return {failure, ""};
    const std::string bad = out_of_band(temp_degc, policy, suspended);
    if (!bad.empty()) return {{}, bad};
  }
  const bool stepped = !stepped_.empty();
  const bool base_due = policy.base_every > 0 && (suspended || since_base_ >= policy.base_every);
  if (base_due || (stepped && devices_->tracker->sees_base())) {
    const Found found = look_at_base(point, suspended);
    if (found.failure.any() || !found.bad.empty()) return found;
  }
  const bool due = policy.reference_every > 0 && !measured_.empty() &&
                   (suspended || since_visit_ >= policy.reference_every);
  if (!due && !stepped) return {};
  const double half = suspended ? 0.5 : 1.0;
  ReferenceTolerance whole{.xy_mm = policy.drift_mm};
  if (stepped) whole.xy_mm = std::max(whole.xy_mm, ReferenceTolerance{}.xy_mm);
  whole = at_least_noise(whole);
  const Visit seen = visit(references(), store::SetUp::as_before,
                           {half * whole.xy_mm, half * whole.phi_rad}, point);
  if (stepped && !seen.off.empty()) return {seen.failure, stepped_ + "; " + seen.off};
  return {seen.failure, seen.off};
}

/// The set-up is where it was: a step of the deviations was the robot's own.
void Runner::believe(const PlannedPoint& point) {
  if (!stepped_.empty()) believed_ = point.seq;
  stepped_.clear();
}

/// Tried as a point is. What is found is on record, and what chance does not explain is said, in
/// the gate or beyond it.
Runner::Found Runner::look_at_base(const PlannedPoint& point, bool suspended) {
  std::map<device::Status, int> failures;
  BaseDrift drift;
  for (;;) {
    const Failure failure = hands_.base(occasion_of(point), drift);
    if (!failure.any()) break;
    const bool again = failure.cause == Failure::Cause::device &&
                       ++failures[failure.status] < tries_for(failure.status);
    if (!again) return {failure, ""};
    progress_->say(fmt::format("base nests: {}; tried again", failure.words()));
    const Failure waited = wait_for_another_try(failure);
    if (waited.any()) return {waited, ""};
  }
  since_base_ = 0;
  const double gate_mm = course_.settings.policy.drift_mm;
  const BaseCheck check =
      judged(drift, suspended ? gate_mm / 2 : gate_mm, static_cast<int>(stood_.size()));
  note(kBaseEvent, base_check_json(check).dump());
  if (check.off) return {{}, words_of(check)};
  if (check.moved) progress_->say(words_of(check) + ": within the gate");
  return {};
}

/// After the last point, so that a drift under it is on record too, and a tracker that was knocked
/// meanwhile ends no session that is done. Where it can't be looked at, a resume settles it.
void Runner::look_at_base_once_more() {
  const bool sees = devices_->virtual_time ? course_.settings.policy.base_every > 0
                                           : devices_->tracker->sees_base();
  if (!sees || since_base_ == 0 || asked_to_stop()) return;
  const Found found = look_at_base(course_.plan.points.back(), false);
  if (found.failure.any()) {
    end_with(found.failure, "base nests after the last point");
  } else if (!found.bad.empty()) {
    progress_->say(found.bad + " after the last point: the last ones are measured again");
    static_cast<void>(settle(doubt(), found.bad + " after the last point"));
  }
}

/// False: the session is stopped, faulted, or paused by the operator meanwhile.
bool Runner::conditions_hold(const PlannedPoint& point) {
  const Policy& policy = course_.settings.policy;
  Found found = look_at_conditions(point, false);
  if (!found.failure.any() && found.bad.empty()) {
    believe(point);
    return true;
  }
  if (!found.failure.any()) {
    advance(Event::conditions_bad);
    note("paused", "conditions: " + found.bad);
    progress_->say("suspended: " + found.bad);
    if (wishes_.now() == Wish::go_on) wishes_.taken();  // of an earlier pause
  }
  for (double waited_s = 0; !found.failure.any() && !found.bad.empty(); waited_s += policy.poll_s) {
    const Wish wish = wishes_.now();
    const bool tired = waited_s >= policy.patience_s;
    if (wish >= Wish::stop || tired) {
      if (tired) {
        detail_ = fmt::format("conditions stayed bad for {:g} s: {}", waited_s, found.bad);
      }
      // A step is seen at the point that makes it, and what is stored comes before it; unless it
      // was preceded by smaller ones, which show when the last points are measured again.
      const Doubt unproven = doubt();
      if (unproven.moved && stepped_.empty()) {
        if (detail_.empty()) detail_ = "stopped by " + surroundings_.stopped_by();
        detail_ += exclude(unproven.points, found.bad);
      } else if (unproven.moved && tired && !settle(unproven, found.bad)) {
        return false;
      }
      advance(Event::stop_asked);
      return false;
    }
    if (wish == Wish::pause) note("paused", "by the operator");
    if (wish != Wish::none) return false;  // asked to go on: set up anew, as after any pause
    pass(policy.poll_s, Wish::go_on);
    found = look_at_conditions(point, true);
  }
  if (found.failure.any()) {
    static_cast<void>(hands_.stop());
    end_with(found.failure, "conditions");
    return false;
  }
  believe(point);
  advance(Event::conditions_good);
  note("resumed", "conditions are good again");
  progress_->say("conditions are good again");
  return true;
}

}  // namespace trammel::session
