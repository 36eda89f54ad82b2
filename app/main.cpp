#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

#include "app/allocator.hpp"
#include "app/cli/archive.hpp"
#include "app/cli/cli.hpp"
#include "app/cli/commands.hpp"
#include "app/standard_streams.hpp"

namespace {

/// `trammel archive …` is a program of its own, beside this one or on PATH: linked with libpq,
/// whose 25 libraries would cost this one 12 ms at each start. It is executed with the same words.
int become_the_archive(char** argv) {
  constexpr const char* kProgram = "trammel-archive";
  std::error_code none;
  const auto own = std::filesystem::read_symlink("/proc/self/exe", none);
  ::execv((own.parent_path() / kProgram).c_str(), argv);
  ::execvp(kProgram, argv);
  return trammel::cli::fail(trammel::ExitCode::not_found,
                            {.what = "the program trammel-archive is not installed",
                             .hint = "it is in the package trammel-archive"},
                            false);
}

}  // namespace

int main(int argc, char** argv) {
  trammel::hold_standard_streams();
  trammel::keep_freed_memory();
  const std::vector<std::string> words(argv + (argc > 0 ? 1 : 0), argv + argc);
  if (trammel::cli::is_for_the_archive(words)) return become_the_archive(argv);
  return trammel::cli::run_cli(words, trammel::cli::commands());
}
