#include <string>
#include <vector>

#include "app/archive/commands.hpp"
#include "app/cli/archive.hpp"
#include "app/cli/cli.hpp"
#include "app/standard_streams.hpp"

/// `trammel-archive push` and `trammel archive push` are the same.
int main(int argc, char** argv) {
  trammel::hold_standard_streams();
  std::vector<std::string> words(argv + (argc > 0 ? 1 : 0), argv + argc);
  if (trammel::cli::first_command(words) != "archive") words.insert(words.begin(), "archive");
  return trammel::cli::run_cli(words, {{"archive", trammel::archive::setup}});
}
