// Each folder of examples/ with a `run` is run as its README says, and prints what its README
// shows.

#include <algorithm>
#include <sstream>

#include "tests/support/catch.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;

namespace {

/// The blocks between ``` lines of a README.
std::vector<std::string> shown(const std::filesystem::path& readme) {
  std::istringstream in(tests::read_text(readme));
  std::vector<std::string> blocks;
  bool inside = false;
  for (std::string line; std::getline(in, line);) {
    if (line == "```") {
      inside = !inside;
      if (inside) blocks.emplace_back();
    } else if (inside) {
      blocks.back() += line + "\n";
    }
  }
  return blocks;
}

}  // namespace

TEST_CASE("every example runs and prints what its README shows", "[cli][examples]") {
  const std::filesystem::path examples = tests::source_folder() + "/examples";
  int n_run = 0;
  for (const auto& entry : std::filesystem::directory_iterator(examples)) {
    const std::filesystem::path script = entry.path() / "run";
    if (!std::filesystem::exists(script)) continue;
    ++n_run;
    CAPTURE(script);
    const tests::TemporaryFolder folder;
    const std::string path = "PATH=" + tests::build_folder() + ":/usr/bin:/bin";
    const tests::Finished done =
        tests::run_command({"env", path, script, folder.path()}, folder.path());
    INFO(done.err);
    CHECK(done.exit_code == 0);
    const auto blocks = shown(entry.path() / "README.md");
    CHECK_FALSE(blocks.empty());
    for (const std::string& block : blocks) CHECK_THAT(done.out, Contains(block));
  }
  CHECK(n_run >= 4);
}
