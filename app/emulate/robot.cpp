#include "app/emulate/robot.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "core/plan/plan.hpp"

namespace trammel::emulate {

namespace {

void check_rail(const RailSetup& setup, int rail) {
  const auto require = [rail](bool holds, const char* field, const char* expected) {
    if (holds) return;
    throw InputError({.what = "the emulated rail " + std::to_string(rail + 1) + " is no rail",
                      .where = {.field = field},
                      .expected = expected});
  };
  const auto positive = [](double v) { return std::isfinite(v) && v > 0; };
  require(positive(setup.lead_mm), "lead_mm", "more than 0");
  require(positive(setup.counts_per_rev), "counts_per_rev", "more than 0");
  require(positive(setup.gear), "gear", "more than 0");
  require(setup.sign == 1 || setup.sign == -1, "sign", "1 or -1");
  require(std::isfinite(setup.home_mm.value_or(0)), "home_mm", "a finite number");
  require(std::abs(setup.lead_error) < 0.5, "lead_error", "-0.5 to 0.5");
  require(setup.switch_margin_mm >= 0, "switch_margin_mm", "0 or more");
}

}  // namespace

NowS wall_clock(double speedup) {
  const auto start = std::chrono::steady_clock::now();
  return [speedup, start] {
    return speedup *
           std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
}

EmulatedRobot::EmulatedRobot(simulate::VirtualRobot robot, const Rails& rails, NowS now)
    : robot_(std::move(robot)), now_(std::move(now)) {
  for (int i = 0; i < kChains; ++i) {
    const RailSetup& setup = rails[static_cast<std::size_t>(i)];
    check_rail(setup, i);
    Rail& rail = rails_[static_cast<std::size_t>(i)];
    rail.setup = setup;
    rail.home_mm = setup.home_mm.value_or(robot_.home_mm()[i]);
    rail.mm_per_count =
        setup.sign * setup.lead_mm * (1 + setup.lead_error) / (setup.counts_per_rev * setup.gear);
    const double start = std::nearbyint(setup.start_mm / rail.mm_per_count);
    const Switches ends = switches(i);
    if (!(start > ends.reverse && start < ends.forward)) {
      throw InputError({.what = "the emulated rail " + std::to_string(i + 1) +
                                " would stand on a limit switch at power-up",
                        .where = {.field = "start_mm"},
                        .got = std::to_string(setup.start_mm)});
    }
    rail.motion = Motion::at_rest(start);
    rail.began_mm = rail.from_mm = place_mm(rail, 0);
  }
}

/// Once the command rests, the place is where the motor settles: how far it is on its way there
/// would depend on the moment somebody looked.
double EmulatedRobot::place_mm(const Rail& rail, double now_s) {
  const MotorState state = rail.motion.at(now_s);
  const bool settles = now_s >= rail.motion.end_s() && !rail.motion.is_blocked();
  const double counts = settles ? state.commanded : state.actual();
  return rail.home_mm + rail.mm_per_count * std::nearbyint(counts);
}

double EmulatedRobot::came_from_mm(const Rail& rail, double now_s) {
  const double at_mm = place_mm(rail, now_s);
  if (rail.homes && now_s >= rail.motion.end_s()) return at_mm;
  return std::abs(at_mm - rail.began_mm) > kStandstillMm ? rail.began_mm : rail.from_mm;
}

EmulatedRobot::Switches EmulatedRobot::switches(int rail) const {
  const Rail& r = rails_[static_cast<std::size_t>(rail)];
  const Limits& limits = robot_.truth().nominal.drives[static_cast<std::size_t>(rail)].limits;
  const double margin = r.setup.switch_margin_mm;
  const double a = (limits.l_min_mm - margin - r.home_mm) / r.mm_per_count;
  const double b = (limits.l_max_mm + margin - r.home_mm) / r.mm_per_count;
  return {std::floor(std::min(a, b)), std::ceil(std::max(a, b))};
}

Motion EmulatedRobot::at_power_up(int rail) const {
  const RailSetup& setup = rails_[static_cast<std::size_t>(rail)].setup;
  return Motion::at_rest(
      std::nearbyint(setup.start_mm / rails_[static_cast<std::size_t>(rail)].mm_per_count));
}

Standing EmulatedRobot::standing() const {
  const std::lock_guard guard(mutex_);
  const double now_s = now_();
  Standing standing;
  for (int i = 0; i < kChains; ++i) {
    const Rail& rail = rails_[static_cast<std::size_t>(i)];
    standing.l_mm[i] = place_mm(rail, now_s);
    standing.from_mm[i] = came_from_mm(rail, now_s);
    standing.moving |= rail.motion.moving(now_s);
  }
  standing.epoch = std::max(1, *std::max_element(homings_.begin(), homings_.end()));
  standing.time_s = work_s_;
  return standing;
}

void EmulatedRobot::begin(std::span<const Start> starts) {
  const std::lock_guard guard(mutex_);
  const double now_s = now_();
  double longest_s = 0;
  for (const Start& start : starts) {
    const auto i = static_cast<std::size_t>(start.rail);
    Rail& rail = rails_[i];
    rail.from_mm = came_from_mm(rail, now_s);
    rail.began_mm = place_mm(rail, now_s);
    rail.homes = start.homes;
    rail.motion = start.motion;
    if (start.homes) ++homings_[i];
    const double way_s = start.motion.duration_s();
    if (std::isfinite(way_s)) longest_s = std::max(longest_s, way_s);
  }
  if (!starts.empty()) work_s_ += longest_s + robot_.truth().motion.settle_s;
}

void EmulatedRobot::change(int rail, const Motion& motion) {
  const std::lock_guard guard(mutex_);
  Rail& r = rails_[static_cast<std::size_t>(rail)];
  const double now_s = now_();
  if (r.homes && now_s >= r.motion.end_s()) r.began_mm = r.from_mm = place_mm(r, now_s);
  r.homes = false;
  r.motion = motion;
}

}  // namespace trammel::emulate
