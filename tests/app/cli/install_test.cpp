// What cmake --install puts on a laboratory's machine. The Debian package is made of it:
// scripts/package checks that.

#include "tests/support/catch.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary.hpp"

using Catch::Matchers::StartsWith;
using namespace trammel;
using tests::Finished;
using tests::run_command;

namespace {

constexpr const char* kInstalled[] = {"bin/trammel",
                                      "bin/trammel-archive",
                                      "share/man/man1/trammel.1.gz",
                                      "share/bash-completion/completions/trammel",
                                      "share/zsh/site-functions/_trammel",
                                      "share/zsh/vendor-completions/_trammel",
                                      "share/fish/vendor_completions.d/trammel.fish",
                                      "share/trammel/schemas/report.schema.json",
                                      "share/trammel/schemas/sql/0001_tables.sql",
                                      "share/doc/trammel/README.md",
                                      "share/doc/trammel/LICENSE",
                                      "share/doc/trammel/copyright",
                                      "share/doc/trammel/examples/paper/protocol.json"};

Finished done(const std::vector<std::string>& words, const std::filesystem::path& folder) {
  Finished finished = run_command(words, folder);
  CAPTURE(words, finished.out, finished.err);
  REQUIRE(finished.exit_code == 0);
  return finished;
}

void check_tree(const std::filesystem::path& prefix, const std::filesystem::path& work) {
  for (const char* file : kInstalled) {
    CAPTURE(file);
    CHECK(std::filesystem::file_size(prefix / file) > 0);
  }
  CHECK(tests::read_text(prefix / "share/doc/trammel/copyright") ==
        tests::run_program({"licenses"}, work).out);
  CHECK_THAT(done({prefix / "bin/trammel", "--version"}, work).out, StartsWith("trammel "));
  CHECK(tests::read_text(prefix / "share/bash-completion/completions/trammel") ==
        tests::run_program({"completion", "bash"}, work).out);
  CHECK(done({"gzip", "-dc", prefix / "share/man/man1/trammel.1.gz"}, work).out ==
        tests::run_program({"man"}, work).out);
}

}  // namespace

TEST_CASE("cmake --install puts program, manual, completions, schemas and examples in their places",
          "[cli]") {
  const tests::TemporaryFolder folder;
  done({"cmake", "--install", tests::build_folder(), "--prefix", folder.path() / "usr"},
       folder.path());
  check_tree(folder.path() / "usr", folder.path());
}
