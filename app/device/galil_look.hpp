#pragma once
// Questions to the controller about all three axes, and bringing them to rest: over any connection,
// also one beside that of a call which does not return.

#include <array>
#include <string>

#include "app/device/galil_settings.hpp"
#include "app/device/galil_wire.hpp"

namespace trammel::device {

using GalilAxes = std::array<GalilAxis, kChains>;

/// The three axes at one moment.
struct GalilLook {
  std::array<bool, kChains> moves{};
  std::array<double, kChains> off_mm{};  // command minus encoder, along the rail
  std::array<int, kChains> stop_code{};
  [[nodiscard]] bool any_moves() const { return moves[0] || moves[1] || moves[2]; }
};
GalilLook look_at(GalilWire& wire, const GalilAxes& axes);

/// `question` once for each axis, in one line: "TPA;TPB;TPC".
std::string each_axis(const std::string& question, const GalilAxes& axes);
std::string letters_of(const GalilAxes& axes);

/// Answers to `question` ("RP", "TP") of all axes, in counts and as displacements.
std::array<std::int64_t, kChains> ask_counts(GalilWire& wire, const GalilAxes& axes,
                                             const std::string& question);
Displacements ask_displacements(GalilWire& wire, const GalilAxes& axes,
                                const std::string& question);

/// ST, and AB1 where that does not help, until no axis moves. False when they still do. Throws
/// LinkError.
[[nodiscard]] bool bring_to_rest(GalilWire& wire, const GalilSettings& settings);

void wait_s(double seconds);

}  // namespace trammel::device
