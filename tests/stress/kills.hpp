#pragma once
// The real program, killed at random times until its campaign is done, again and again.

#include <cstdint>
#include <filesystem>
#include <string>

namespace trammel::test {

struct KillCount {
  int campaigns = 0;
  int points = 0;       // stored in the end, of the last campaign
  int kills = 0;        // that hit a running program
  int with_points = 0;  // of these, with acknowledged points of the life that ended
  int lost = 0;         // kills after which an acknowledged point was missing
  int corrupt = 0;      // kills after which the database did not verify
  int repeated = 0;     // points with two ok attempts, of all campaigns
  int different = 0;    // readings with other bits than those of an undisturbed campaign; over
                        // sockets: that are not where the robot was at that command
  std::string first_problem = {};
};

struct KillOptions {
  int kills = 500;
  std::uint64_t seed = 20240973;
  bool loses_log = false;  // the control: the log does not outlive a kill; ends with the first loss
};

/// Runs `session run|resume` over 80 points on a terminal of its own, where the program says of
/// each point that it is stored, until `kills` have hit.
KillCount sweep_kills(const std::filesystem::path& folder, const KillOptions& options);

/// The same over sockets: one campaign of `points` on the emulators' servers, the program killed
/// while it homes, moves, measures and stores, `kills` times, and then left to come to its end.
KillCount sweep_socket_kills(const std::filesystem::path& folder, int points, int kills,
                             std::uint64_t seed = 20240973);

}  // namespace trammel::test
