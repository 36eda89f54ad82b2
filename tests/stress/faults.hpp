#pragma once
// The n-th operation of a recorder fails, once or for good: is it said, and is anything lost?

#include <cstdint>
#include <filesystem>
#include <string>

#include "tests/stress/recorder.hpp"

namespace trammel::test {

enum class Fault { io_error, disk_full, out_of_memory };

struct FaultOptions {
  Fault fault = Fault::io_error;
  bool for_good = false;
  std::int64_t every = 1;  // n = 1, 1 + every, … to the last operation
  int n_points = 4;
  Recorder recorder = real_recorder();
};

struct FaultCount {
  std::int64_t operations = 0;  // of an undisturbed session: the last n
  int runs = 0;
  int reported = 0;    // runs that ended in an error
  int unreported = 0;  // lasting faults that came to nobody's ears: must be 0
  int lost = 0;        // runs after which an acknowledged point is missing
  int corrupt = 0;     // runs after which the database does not open or does not verify
  int unfinished = 0;  // runs after which the session can not be finished
  std::string first_problem = {};
  [[nodiscard]] int violations() const { return unreported + lost + corrupt + unfinished; }
};

/// Records a session of `n_points` once for each n, with the fault at its n-th operation; then,
/// without faults, looks at the database and finishes the session. `folder` is used for files.
FaultCount sweep_faults(const std::filesystem::path& folder, const FaultOptions& options);

}  // namespace trammel::test
