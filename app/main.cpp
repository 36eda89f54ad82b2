#include <malloc.h>

#include <string>
#include <vector>

#include "app/cli/cli.hpp"
#include "app/cli/commands.hpp"

namespace {

// What threads free they take again with the next campaign. Given back in between, it costs calls
// of the kernel under a lock of all threads: a third of the gain from a second core.
void keep_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_TRIM_THRESHOLD, 64 << 20);
  mallopt(M_TOP_PAD, 1 << 20);
#endif
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  const std::vector<std::string> words(argv + (argc > 0 ? 1 : 0), argv + argc);
  return trammel::cli::run_cli(words, trammel::cli::commands());
}
