#pragma once
// One axis of the controller: millimetres of rail to counts of encoder, and moves that end
// together.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace trammel::device {

/// counts = sign (l - zero) counts_per_rev gear / lead                                         (1)
/// counts_per_rev is four times the pulses that the drive puts out per turn of the motor [K:
/// Yaskawa's Pn212]; gear is turns of the motor per turn of the screw; zero is the displacement at
/// count 0, which is where homing ends.
struct GalilAxis {
  char letter = 'A';
  double lead_mm = 10;
  double counts_per_rev = 8192;
  double gear = 1;
  int sign = 1;  // -1: counts fall where the displacement grows
  double zero_mm = 0;

  [[nodiscard]] double counts_per_mm() const { return counts_per_rev * gear / lead_mm; }
  [[nodiscard]] double mm(double counts) const { return zero_mm + sign * counts / counts_per_mm(); }
};

/// One for each drive: one to three.
using GalilAxes = std::vector<GalilAxis>;

// What the controller takes.
inline constexpr std::int64_t kGalilMaxCounts = 2'147'483'647;
inline constexpr std::int64_t kGalilSpeedStep = 2;            // counts/s
inline constexpr std::int64_t kGalilMaxSpeed = 15'000'000;    // [K]
inline constexpr std::int64_t kGalilAccelerationStep = 1024;  // counts/s^2
inline constexpr std::int64_t kGalilMaxAcceleration = 1'073'740'800;

/// The count nearest to a displacement by (1); nothing for one that is not finite or beyond the
/// controller's range.
std::optional<std::int64_t> counts_of(const GalilAxis& axis, double l_mm);

/// Speed in steps of 2 counts/s, the nearest; acceleration in steps of 1024 counts/s^2, not below
/// what is asked for. Nothing for what the controller cannot do: it is never cut to size.
std::optional<std::int64_t> speed_counts(const GalilAxis& axis, double mm_s);
std::optional<std::int64_t> acceleration_counts(const GalilAxis& axis, double mm_s2);

struct GalilAxisMove {
  std::int64_t to_counts = 0;
  std::int64_t distance_counts = 0;  // with sign; 0: this axis is not started
  std::int64_t speed = 0;            // 0 where it is not started
  std::int64_t acceleration = 0;
};

struct GalilMove {
  std::vector<GalilAxisMove> axes;
  double time_s = 0;  // until the last axis has reached its place
};

/// A move of all axes in proportion, which start and end together.
///
/// The axis with the longest way d in mm has the stated speed v and acceleration a:
///   T = d / v + v / a   where it reaches v,  2 sqrt(d / a) where not (2)
/// The others get the acceleration a d_i / d, rounded up to what the controller takes, and with it
/// the speed that needs the same time:
///   v_i = a_i / 2 (T - sqrt(T^2 - 4 d_i / a_i)) (3)
/// rounded up to even counts/s: they never end after the first, and before it by no more than the
/// share 2 / v_i of T.
/// Preconditions: as many counts as axes, within the range, speed and acceleration as speed_counts
/// and acceleration_counts take them. Proof: galil_axis_test.cpp.
GalilMove plan_galil_move(std::span<const GalilAxis> axes,
                          std::span<const std::int64_t> from_counts,
                          std::span<const std::int64_t> to_counts, double speed_mm_s,
                          double acceleration_mm_s2);

/// (2)
double travel_time_s(double distance, double speed, double acceleration);

}  // namespace trammel::device
