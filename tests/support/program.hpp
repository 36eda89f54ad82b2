#pragma once
// Runs the built program as a user does.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/paths.hpp"
#include "tests/support/temporary.hpp"

namespace trammel::tests {

/// A campaign of the paper's plan with a hidden drive error, as a folder that can be imported.
inline const std::string kDriveError = source_folder() + "/tests/support/campaigns/drive-error";

struct Finished {
  int exit_code = 0;  // -1: killed by a signal
  std::string out, err;
};

/// Runs `trammel WORDS…` in `folder`, without TRAMMEL_DB, stdin empty, stdout and stderr in files.
/// `kill_after_ms`: SIGKILL after that time.
Finished run_program(const std::vector<std::string>& words, const std::filesystem::path& folder,
                     std::optional<int> kill_after_ms = {});

/// A program that serves until it is told to stop.
class Served {
 public:
  Served(const std::vector<std::string>& words, const std::filesystem::path& folder);
  ~Served();  // killed, if it has not been stopped
  Served(const Served&) = delete;
  Served& operator=(const Served&) = delete;

  /// Its first line on stdout, awaited; what came instead if it ends without one.
  std::string first_line();
  /// Sends the signal and waits for the end; stdout whole.
  Finished stop(int signal);

 private:
  TemporaryFolder files_;
  int child_ = -1;
  int out_ = -1;  // our end of its stdout
  std::string read_;
};
/// Runs another program the same way: its name or path, and its arguments.
Finished run_command(const std::vector<std::string>& words, const std::filesystem::path& folder);

/// All that the program writes to a terminal of its own; NO_COLOR set or not there.
std::string run_on_terminal(const std::vector<std::string>& words,
                            const std::filesystem::path& folder, bool no_color, int columns = 120);

}  // namespace trammel::tests
