#include "app/device/galil_axis.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace trammel::device {

namespace {

std::int64_t up_to_step(double value, std::int64_t step) {
  return step * std::max<std::int64_t>(
                    1, static_cast<std::int64_t>(std::ceil(value / static_cast<double>(step))));
}

std::optional<std::int64_t> within(double value, std::int64_t least, std::int64_t most) {
  // Not a number compares false, too.
  if (!(value >= static_cast<double>(least) && value <= static_cast<double>(most))) return {};
  return static_cast<std::int64_t>(value);
}

/// (3), rounded up; a way so short that the rounded acceleration leaves nothing to slow down.
std::int64_t speed_in_time(double distance, double time_s, std::int64_t acceleration) {
  const auto a = static_cast<double>(acceleration);
  const double root = std::sqrt(std::max(0.0, time_s * time_s - 4 * distance / a));
  // d_i / T times two over (1 + root / T): the same as (3) without its cancellation.
  return up_to_step(2 * distance / (time_s + root), kGalilSpeedStep);
}

}  // namespace

std::optional<std::int64_t> counts_of(const GalilAxis& axis, double l_mm) {
  const double counts = axis.sign * (l_mm - axis.zero_mm) * axis.counts_per_mm();
  return within(std::nearbyint(counts), -kGalilMaxCounts, kGalilMaxCounts);
}

std::optional<std::int64_t> speed_counts(const GalilAxis& axis, double mm_s) {
  const double steps = std::nearbyint(mm_s * axis.counts_per_mm() / kGalilSpeedStep);
  return within(steps * kGalilSpeedStep, kGalilSpeedStep, kGalilMaxSpeed);
}

std::optional<std::int64_t> acceleration_counts(const GalilAxis& axis, double mm_s2) {
  const double steps = std::ceil(mm_s2 * axis.counts_per_mm() / kGalilAccelerationStep);
  return within(steps * kGalilAccelerationStep, kGalilAccelerationStep, kGalilMaxAcceleration);
}

double travel_time_s(double distance, double speed, double acceleration) {
  const double to_speed = speed * speed / acceleration;  // way of both ramps together
  return distance >= to_speed ? distance / speed + speed / acceleration
                              : 2 * std::sqrt(distance / acceleration);
}

GalilMove plan_galil_move(std::span<const GalilAxis> axes,
                          std::span<const std::int64_t> from_counts,
                          std::span<const std::int64_t> to_counts, double speed_mm_s,
                          double acceleration_mm_s2) {
  GalilMove move;
  move.axes.resize(axes.size());
  std::vector<double> way_mm(axes.size());
  std::size_t longest = 0;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    move.axes[i].to_counts = to_counts[i];
    move.axes[i].distance_counts = to_counts[i] - from_counts[i];
    way_mm[i] =
        std::abs(static_cast<double>(move.axes[i].distance_counts)) / axes[i].counts_per_mm();
    if (way_mm[i] > way_mm[longest]) longest = i;
  }
  if (way_mm[longest] == 0) return move;
  const auto speed = speed_counts(axes[longest], speed_mm_s);
  const auto acceleration = acceleration_counts(axes[longest], acceleration_mm_s2);
  TRAMMEL_ASSERT(speed.has_value() && acceleration.has_value());
  const double distance = way_mm[longest] * axes[longest].counts_per_mm();
  move.time_s =
      travel_time_s(distance, static_cast<double>(*speed), static_cast<double>(*acceleration));
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (way_mm[i] == 0) continue;
    GalilAxisMove& axis = move.axes[i];
    if (i == longest) {
      axis.speed = *speed;
      axis.acceleration = *acceleration;
      continue;
    }
    const double way = way_mm[i] * axes[i].counts_per_mm();
    axis.acceleration =
        up_to_step(static_cast<double>(*acceleration) * way / distance, kGalilAccelerationStep);
    axis.speed = speed_in_time(way, move.time_s, axis.acceleration);
  }
  return move;
}

}  // namespace trammel::device
