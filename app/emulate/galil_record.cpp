// What the controller tells of an axis, as numbers and as the binary record of QR.

#include <algorithm>
#include <cmath>

#include "app/emulate/galil.hpp"

namespace trammel::emulate {

namespace {

constexpr std::size_t kHeader = 82, kAxisBlock = 36;
constexpr double kMaxVolts = 9.9982;  // [K] of the 16-bit converter behind the torque command

/// Little endian, like the size in the header [K].
template <class T>
void put(std::string& record, std::size_t at, T value) {
  auto bits = static_cast<std::uint64_t>(value);
  for (std::size_t k = 0; k < sizeof(T); ++k, bits >>= 8) {
    record[at + k] = static_cast<char>(bits & 0xff);
  }
}

std::int32_t whole(double value) {
  constexpr double kMost = 2147483647.0;
  return static_cast<std::int32_t>(std::clamp(std::nearbyint(value), -kMost - 1, kMost));
}

std::uint16_t status_word(const Axis& axis, double now_s) {
  const double v = axis.motion.at(now_s).velocity, speed = std::abs(v);
  const double later = std::abs(axis.motion.at(now_s + 1e-3).velocity);
  const bool moves = axis.running;
  const bool slows = moves && later < speed;
  const bool stopping = slows && axis.ends_with != kArrived && axis.ends_with != kHomed;
  const bool positions = axis.next == Next::position || axis.next == Next::relative;
  const auto bit = [](bool set, int n) { return static_cast<unsigned>(set) << n; };
  return static_cast<std::uint16_t>(
      bit(axis.off, 0) | bit(slows, 3) | bit(stopping, 4) | bit(moves && later == speed, 5) |
      bit(v < 0, 7) | bit(axis.next == Next::position, 13) | bit(positions, 14) | bit(moves, 15));
}

}  // namespace

Tells tells(Galil& galil, int index) {
  const Axis& axis = galil.axis(index);
  const MotorState state = axis.motion.at(galil.now_s());
  Tells told;
  told.position = std::nearbyint(state.actual() - axis.zero);
  told.commanded = std::nearbyint(state.commanded - axis.zero);
  told.error = told.commanded - told.position;
  // x' = e / T of the servo's lag; a blocked motor has lag and no velocity.
  told.velocity = axis.motion.is_blocked() ? 0 : std::nearbyint(state.lag / Motion::kServoLag_s);
  told.torque_v = std::clamp(axis.kp * told.error * 20 / 65536, -kMaxVolts, kMaxVolts);
  if (axis.off) told.torque_v = 0;
  const int on = galil.on_switch(axis);
  const auto bit = [](bool set, int n) { return static_cast<unsigned>(set) << n; };
  told.status = static_cast<std::uint8_t>(
      bit(axis.running, 7) | bit(std::abs(told.error) > axis.error_limit, 6) | bit(axis.off, 5) |
      bit(on <= 0, 3) | bit(on >= 0, 2) | bit(state.actual() >= 0, 1) | bit(true, 0));
  return told;
}

std::string data_record(Galil& galil) {
  std::string record(kHeader + kAxes * kAxisBlock, '\0');
  record[0] = '\x87';  // [K] blocks that follow: I, S and T, then one bit an axis
  record[1] = '\xff';
  put(record, 2, static_cast<std::uint16_t>(record.size()));
  const double now_s = galil.now_s();
  put(record, 4, static_cast<std::uint16_t>(std::fmod(now_s * 1000, 65536)));
  put(record, 50, static_cast<std::uint8_t>(galil.error));
  std::uint32_t amplifier = 0;
  for (int k = 0; k < kAxes; ++k) {
    const Axis& axis = galil.axis(k);
    const Tells told = tells(galil, k);
    const std::size_t at = kHeader + static_cast<std::size_t>(k) * kAxisBlock;
    put(record, at, status_word(axis, now_s));
    put(record, at + 2, static_cast<std::uint8_t>(told.status & 0x0e));  // bit 0: a stepper
    put(record, at + 3, static_cast<std::uint8_t>(axis.stop_code));
    put(record, at + 4, whole(told.commanded));
    put(record, at + 8, whole(told.position));
    put(record, at + 12, whole(told.error));
    put(record, at + 20, whole(told.velocity * 64));
    put(record, at + 24, whole(told.torque_v * 3255));
    amplifier |= static_cast<std::uint32_t>(axis.amplifier_fault) << k;
  }
  put(record, 52, amplifier);  // [K] one bit an axis
  return record;
}

}  // namespace trammel::emulate
