#include "app/device/galil_settings.hpp"

#include <fmt/format.h>

#include <optional>
#include <vector>

#include "core/error.hpp"
#include "core/plan/check.hpp"

namespace trammel::device {

namespace {

[[noreturn]] void refuse_setting(const std::string& field, const std::string& what,
                                 const std::string& expected = "") {
  throw InputError({.what = what, .where = {.field = field}, .expected = expected});
}

void require(bool holds, const std::string& field, const std::string& what,
             const std::string& expected = "") {
  if (!holds) refuse_setting(field, what, expected);
}

void validate_axis(const GalilSettings& s, std::size_t i) {
  const GalilAxis& axis = s.axes[i];
  const std::string path = fmt::format("axes[{}].", i);
  require(axis.letter >= 'A' && axis.letter <= 'H', path + "axis", "no such axis", "A to H");
  for (std::size_t k = 0; k < i; ++k) {
    require(s.axes[k].letter != axis.letter, path + "axis", "two drives on one axis");
  }
  require(axis.lead_mm > 0, path + "lead_mm", "a lead that is not positive");
  require(axis.counts_per_rev > 0, path + "counts_per_rev", "no counts");
  require(axis.gear > 0, path + "gear", "a gear that is not positive");
  require(axis.sign == 1 || axis.sign == -1, path + "sign", "no direction", "1 or -1");
  const Limits& limits = s.machine.drives[i].limits;
  require(counts_of(axis, limits.l_min_mm) && counts_of(axis, limits.l_max_mm),
          path + "counts_per_rev", "the stroke is beyond the controller's counts",
          fmt::format("at most {} either way from home", kGalilMaxCounts));
  const double count_mm = 1 / axis.counts_per_mm();
  require(s.settle_band_mm >= count_mm, "motion.settle_band_mm",
          "a settling band below one count of the encoder", fmt::format("{:.6f} mm", count_mm));
}

void validate_speeds(const GalilSettings& s) {
  for (const GalilAxis& axis : s.axes) {
    const double least_mm_s = kGalilSpeedStep / axis.counts_per_mm();
    const std::string speeds =
        fmt::format("{:.6g} to {:.6g} mm/s on axis {}", least_mm_s,
                    static_cast<double>(kGalilMaxSpeed) / axis.counts_per_mm(), axis.letter);
    require(speed_counts(axis, s.speed_mm_s).has_value(), "motion.speed_mm_s",
            "a speed that the controller cannot do", speeds);
    require(speed_counts(axis, s.homing_speed_mm_s).has_value(), "homing.speed_mm_s",
            "a speed that the controller cannot do", speeds);
    require(s.acceleration_mm_s2 > 0 && acceleration_counts(axis, s.acceleration_mm_s2),
            "motion.acceleration_mm_s2", "an acceleration that the controller cannot do",
            fmt::format("at most {:.6g} mm/s^2 on axis {}",
                        static_cast<double>(kGalilMaxAcceleration) / axis.counts_per_mm(),
                        axis.letter));
  }
}

void validate_times(const GalilSettings& s) {
  struct Time {
    const char* field;
    double value_s;
    bool may_be_zero;
  };
  for (const Time& t : {Time{"controller.connect_timeout_s", s.connect_timeout_s, false},
                        {"controller.reply_timeout_s", s.reply_timeout_s, false},
                        {"motion.poll_s", s.poll_s, true},
                        {"motion.margin_s", s.margin_s, false},
                        {"motion.settle_s", s.settle_s, true},
                        {"motion.settle_timeout_s", s.settle_timeout_s, false},
                        {"homing.timeout_s", s.homing_timeout_s, false}}) {
    require((t.value_s > 0 || (t.may_be_zero && t.value_s == 0)) && t.value_s <= 3600, t.field,
            "no usable time", "seconds, at most an hour");
  }
  // Fed eight times within it: less leaves no room for a busy computer's tens of milliseconds.
  constexpr double kLeastWatchS = 0.2, kMostWatchS = 60;
  require(s.watch_host_s == 0 || (s.watch_host_s >= kLeastWatchS && s.watch_host_s <= kMostWatchS),
          "controller.watch_host_s", "no usable time",
          fmt::format("{} to {} s, or 0: no watch", kLeastWatchS, kMostWatchS));
  require(s.settle_timeout_s > s.settle_s, "motion.settle_timeout_s",
          "the wait ends before the stage could have settled");
}

/// The stage comes from where homing leaves the drives to home, straight in joint space. The
/// switches may lie outside the stroke; the way between must be one that the platform can go.
void validate_way_home(const GalilSettings& s) {
  Displacements switches = Displacements::Zero();
  for (std::size_t i = 0; i < s.axes.size(); ++i) {
    switches[static_cast<int>(i)] = s.axes[i].zero_mm;
  }
  for (const Violation& v : check_path(s.machine, std::vector<Displacements>{switches}, {})) {
    if (v.what == Violation::What::lower_limit || v.what == Violation::What::upper_limit) continue;
    refuse_setting("axes[0].zero_mm",
                   "the way between the home switches and home is not safe: " + describe(v));
  }
}

}  // namespace

void validate(const GalilSettings& s) {
  validate_times(s);
  for (std::size_t i = 0; i < s.axes.size(); ++i) validate_axis(s, i);
  validate_speeds(s);
  require(s.following_mm > s.settle_band_mm, "motion.following_mm",
          "the gate while moving is not wider than the settling band");
  for (const GalilAxis& axis : s.axes) {  // twice of it is the controller's own watch
    const double most_mm = static_cast<double>(kGalilMaxCounts) / 2 / axis.counts_per_mm();
    require(s.following_mm < most_mm, "motion.following_mm",
            "a gate beyond the controller's counts", fmt::format("less than {:.6g} mm", most_mm));
  }
  validate_way_home(s);
}

}  // namespace trammel::device
