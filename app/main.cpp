#include <string>
#include <vector>

#include "app/cli/cli.hpp"
#include "app/cli/commands.hpp"

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + (argc > 0 ? 1 : 0), argv + argc);
  return trammel::cli::run_cli(words, trammel::cli::commands());
}
