// --out FILE: one way to say where a command's data goes.

#include "app/cli/sink.hpp"

#include <cstdio>

#include "tests/support/catch.hpp"
#include "tests/support/in_process.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using tests::run_here;

TEST_CASE("--out takes what any command prints, text or JSON, and prints nothing", "[cli]") {
  const tests::TemporaryFolder folder;
  const std::string robot = tests::source_folder() + "/examples/paper/robot.json";
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{}, std::vector<std::string>{"--json"}}) {
    std::vector<std::string> words = {"mechanism", "ik", robot, "--pose", "1", "2", "3"};
    words.insert(words.end(), more.begin(), more.end());
    const auto printed = run_here(words, folder.path());
    words.insert(words.end(), {"--out", more.empty() ? "a.txt" : "a.json"});
    const auto written = run_here(words, folder.path());
    CHECK(written.exit_code == 0);
    CHECK(written.out.empty());
    CHECK(printed.out.size() > 10);
    CHECK(tests::read_text(folder.path() / (more.empty() ? "a.txt" : "a.json")) == printed.out);
  }
}

TEST_CASE("--out takes version and help as well, wherever it stands", "[cli]") {
  const tests::TemporaryFolder folder;
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"--version"}, {"--version", "--json"}, {"report", "--help"}}) {
    CAPTURE(words);
    const auto printed = run_here(words, folder.path());
    std::vector<std::string> into = words;
    into.insert(into.end(), {"--out", "a.txt", "--overwrite"});
    const auto written = run_here(into, folder.path());
    CHECK(written.exit_code == 0);
    CHECK(written.out.empty());
    CHECK(tests::read_text(folder.path() / "a.txt") == printed.out);
    std::filesystem::remove(folder.path() / "a.txt");
  }
}

TEST_CASE("a file that is there is refused before the command runs, a failed command writes none",
          "[cli]") {
  const tests::TemporaryFolder folder;
  write_output(folder.path() / "a.txt", "mine", Existing::refuse);
  const auto refused = run_here(
      {"mechanism", "ik", "nowhere", "--pose", "1", "2", "3", "--out", "a.txt"}, folder.path());
  CHECK(refused.exit_code == 4);  // not 3: nobody looked for the mechanism
  CHECK_THAT(refused.err, Contains("--overwrite"));
  CHECK(tests::read_text(folder.path() / "a.txt") == "mine");
  const auto failed = run_here(
      {"mechanism", "ik", "nowhere", "--pose", "1", "2", "3", "--out", "b.txt"}, folder.path());
  CHECK(failed.exit_code == 3);
  CHECK_FALSE(std::filesystem::exists(folder.path() / "b.txt"));
}

TEST_CASE("what was printed before a sink and after it goes where it went", "[cli]") {
  const tests::TemporaryFolder folder;
  {
    cli::Sink sink(folder.path() / "kept.txt", Existing::refuse);
    std::fputs("in the file\n", stdout);
    sink.deliver();
  }
  {
    cli::Sink sink(folder.path() / "lost.txt", Existing::refuse);
    std::fputs("thrown away\n", stdout);
  }
  CHECK(tests::read_text(folder.path() / "kept.txt") == "in the file\n");
  CHECK_FALSE(std::filesystem::exists(folder.path() / "lost.txt"));
}
