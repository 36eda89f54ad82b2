#pragma once
// From a table of positions to a campaign of an XY stage or of an axis.

#include <optional>
#include <string>

#include "app/files/positions_file.hpp"
#include "core/measure/reading.hpp"

namespace trammel {

struct PositionsUse {
  std::string kind = "XY";                 // or "X": what the table is taken for
  std::string name = {};                   // empty: the file's, without its ending
  std::optional<Machine> machine = {};     // none: assumed, and said so in the facts
  std::optional<TrackerSigma> sigma = {};  // of one reading
  bool in_order = false;                   // rows stand as they were measured, one after the other
  int fit_every = 1;  // nodes on every so-many-th line of targets are fitted, others validate
  bool simulated = false;
};

/// Readings in the order of the file, commanded by the machine's inverse kinematics. Where each
/// move began: of an axis with directions, at the distance of the nearest other target; of rows in
/// order, at the command before; else at the command itself, so that no direction is invented.
/// An assumed machine has square guides, a lead of 10 mm and a stroke that holds the commands; its
/// home is the origin where the grid holds it, else the middle. The machine's `measured` becomes
/// what the file measured.
/// Throws InputError for a machine of another kind, a coordinate that it measures and the file has
/// not, one that the file has and its kind cannot measure, targets out of reach.
/// Proof: positions_campaign_test.cpp.
Campaign campaign_of_positions(const PositionsFile& file, const PositionsUse& use);

}  // namespace trammel
