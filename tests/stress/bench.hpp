#pragma once
// A hostile bench: what lies, doubles, knocks, asks to stop, kills, moves and removes files, at
// random moments of campaigns over sockets and files; each with its control.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace trammel::test {

struct BenchRow {
  std::string figure;
  std::string demand;
  int runs = 0;
  int done = 0;      // that came to their end all the same
  int readings = 0;  // stored in all
  int wrong = 0;     // runs that break the demand
  // where the row is judged by it:
  std::optional<int> falsehoods = {};  // readings left valid that are not what the robot did
  std::optional<int> lost = {};        // readings acknowledged and not there, nothing reported
  double worst_s = 0;    // from a wish to the stop command, of the rows that measure it
  bool control = false;  // must break it at least once
  std::string first_problem = {};

  [[nodiscard]] bool reached() const { return runs > 0 && (wrong > 0) == control; }
};

/// Answers of the tracker and the stage that are not what was asked for: renamed, of a pose or a
/// line before, frozen, dated, doubled, without a number, knocked, an encoder that is off. `runs`
/// campaigns of eight points for each kind, the moment random; controls that lack what looks.
std::vector<BenchRow> lying_bench(int runs, std::uint64_t seed);
/// For how many kinds.
int kinds_of_lies();

/// A wish to stop now in every state of a session, in the time of the wall: to the stop command,
/// and to rails at rest (v / a later). `runs` for each state; a control that asks to finish the
/// point.
std::vector<BenchRow> stop_bench(int runs, std::uint64_t seed);

/// The real program while its rails move: HUP and TERM (stopped by it), KILL (stopped by the
/// controller that watches it), and the control, KILL of one that is not watched; two runners on
/// one controller or one database, and the control, each on its own.
std::vector<BenchRow> signal_bench(int runs);

/// The database removed, moved, restored over, replaced, its disk full under a session, at a random
/// point: an error, or every acknowledged reading is there by name. Controls that look at no
/// answer.
std::vector<BenchRow> file_bench(int runs, std::uint64_t seed);

}  // namespace trammel::test
