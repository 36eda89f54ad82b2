#pragma once
// Questions to the controller about all axes, and bringing them to rest: over any connection,
// also one beside that of a call which does not return.

#include <algorithm>
#include <string>
#include <vector>

#include "app/device/galil_settings.hpp"
#include "app/device/galil_wire.hpp"
#include "core/mechanism/displacements.hpp"

namespace trammel::device {

/// The axes at one moment.
struct GalilLook {
  struct Axis {
    bool moves = false;
    double off_mm = 0;  // command minus encoder, along the drive
    int stop_code = 0;
  };
  std::vector<Axis> axes;
  [[nodiscard]] bool any_moves() const { return std::ranges::any_of(axes, &Axis::moves); }
};
GalilLook look_at(GalilWire& wire, const GalilAxes& axes);

/// `question` once for each axis, in one line: "TPA;TPB;TPC".
std::string each_axis(const std::string& question, const GalilAxes& axes);
std::string letters_of(const GalilAxes& axes);

/// Answers to `question` ("RP", "TP") of all axes, in counts and as displacements; 0 of a drive
/// that the machine has not.
std::vector<std::int64_t> ask_counts(GalilWire& wire, const GalilAxes& axes,
                                     const std::string& question);
Displacements ask_displacements(GalilWire& wire, const GalilAxes& axes,
                                const std::string& question);

/// ST, and AB1 where that does not help, until no axis moves. False when they still do. Throws
/// LinkError.
[[nodiscard]] bool bring_to_rest(GalilWire& wire, const GalilSettings& settings);

void wait_s(double seconds);

}  // namespace trammel::device
