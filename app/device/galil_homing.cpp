// From servos that are off to a stage whose counts are displacements.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/device/galil.hpp"
#include "app/device/galil_look.hpp"
#include "core/error.hpp"
#include "core/mechanism/machine_solver.hpp"

namespace trammel::device {

namespace {

constexpr std::int64_t kNoForwardLimit = kGalilMaxCounts;
constexpr std::int64_t kNoReverseLimit = -kGalilMaxCounts - 1;
constexpr int kHomeFound = 10;              // stop code
constexpr double kFineHomingShare = 0.125;  // of the homing speed: the second look at the switch

struct SoftLimits {
  std::int64_t forward = 0;
  std::int64_t reverse = 0;
};

/// The stroke in counts, rounded to the inside.
SoftLimits soft_limits(const GalilAxis& axis, const Limits& stroke) {
  const auto at = [&](double l_mm) {
    return axis.sign * (l_mm - axis.zero_mm) * axis.counts_per_mm();
  };
  const double a = at(stroke.l_min_mm), b = at(stroke.l_max_mm);
  return {static_cast<std::int64_t>(std::floor(std::max(a, b))),
          static_cast<std::int64_t>(std::ceil(std::min(a, b)))};
}

}  // namespace

StageReport GalilStage::home() {
  const std::scoped_lock lock(busy_);
  homed_ = false;
  return guarded([&] {
    StageReport report = find_switches();
    if (!report.ok()) return report;
    report = travel(drives_of(settings_.machine, settings_.machine.home), {});
    if (!report.ok()) return report;
    set_soft_limits();
    homed_ = true;
    return report;
  });
}

/// Servos on, with the controller's own watch over them: off at twice the gate that is looked at
/// from here. The switches may lie beyond the stroke, so its limits come later.
void GalilStage::set_up_axes() {
  for (std::size_t i = 0; i < settings_.axes.size(); ++i) {
    const GalilAxis& axis = settings_.axes[i];
    const double gate = std::ceil(2 * settings_.following_mm * axis.counts_per_mm());
    set("ER", i, static_cast<std::int64_t>(gate));
    set("OE", i, 1);
    set("FL", i, kNoForwardLimit);
    set("BL", i, kNoReverseLimit);
    wire_->command(std::string("SH") + axis.letter);
  }
  for (const double off : wire_->ask_numbers(each_axis("MG _MO", settings_.axes))) {
    if (off != 0) {
      throw GalilRefusal(0, {.what = "a servo does not switch on",
                             .hint = "look at the drives and the emergency stop"});
    }
  }
}

/// Loaded anew each time: a controller that was reset has none.
void GalilStage::watch_host() {
  if (settings_.watch_host_s == 0) return;
  watch_.reset();
  watch_ = std::make_unique<GalilHostWatch>(*wire_, settings_);
}

StageReport GalilStage::find_switches() {
  // Of a program before this one, that was killed while they moved.
  if (look_at(*wire_, settings_.axes).any_moves() && !bring_to_rest(*wire_, settings_)) {
    return {Status::fault, "the rails move and do not stop: use the emergency stop"};
  }
  watch_host();
  set_up_axes();
  const std::string all = letters_of(settings_.axes);
  for (std::size_t i = 0; i < settings_.axes.size(); ++i) {
    const GalilAxis& axis = settings_.axes[i];
    const std::int64_t speed = *speed_counts(axis, settings_.homing_speed_mm_s);
    const std::int64_t acceleration = *acceleration_counts(axis, settings_.acceleration_mm_s2);
    const double fine = kFineHomingShare * static_cast<double>(speed) / kGalilSpeedStep;
    set("AC", i, acceleration);
    set("DC", i, acceleration);
    set("SP", i, speed);
    set("HV", i, kGalilSpeedStep * std::max<std::int64_t>(1, std::llround(fine)));
    wire_->command(std::string("HM") + axis.letter);
  }
  wire_->command("BG" + all);
  StageReport report = follow(all, settings_.homing_timeout_s, kHomeFound, {});
  if (!report.ok()) {
    report.detail = "homing: " + report.detail;
    return report;
  }
  for (std::size_t i = 0; i < settings_.axes.size(); ++i) {
    wire_->command(fmt::format("DP{}=0", settings_.axes[i].letter));
  }
  return report;
}

void GalilStage::set_soft_limits() {
  for (std::size_t i = 0; i < settings_.axes.size(); ++i) {
    const SoftLimits limits = soft_limits(settings_.axes[i], settings_.machine.drives[i].limits);
    set("FL", i, limits.forward);
    set("BL", i, limits.reverse);
  }
}

/// A controller that was reset or switched off has other limits and its servos off; then its counts
/// mean nothing.
bool GalilStage::remembers_set_up() {
  for (const double off : wire_->ask_numbers(each_axis("MG _MO", settings_.axes))) {
    if (off != 0) return false;
  }
  for (std::size_t i = 0; i < settings_.axes.size(); ++i) {
    const GalilAxis& axis = settings_.axes[i];
    const SoftLimits limits = soft_limits(axis, settings_.machine.drives[i].limits);
    const auto took = wire_->ask_numbers(fmt::format("FL{0}=?;BL{0}=?", axis.letter));
    if (took[0] != static_cast<double>(limits.forward)) return false;
    if (took[1] != static_cast<double>(limits.reverse)) return false;
  }
  return true;
}

}  // namespace trammel::device
