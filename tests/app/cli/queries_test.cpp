// The questions in examples/queries, asked as a person asks them.

#include <algorithm>
#include <filesystem>

#include "tests/support/catch.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary.hpp"

using trammel::tests::read_text;
using trammel::tests::run_program;

TEST_CASE("each question of examples/queries has the answer that stands beside it", "[cli]") {
  const std::filesystem::path folder =
      std::filesystem::path(trammel::tests::source_folder()) / "examples/queries";
  const trammel::tests::TemporaryFolder lab;
  std::filesystem::copy_file(folder / "laboratory.sqlite3", lab.path() / "laboratory.sqlite3");
  const auto ask = [&lab](const std::vector<std::string>& words) {
    std::vector<std::string> all = words;
    all.insert(all.end(), {"--db", "laboratory.sqlite3"});
    return run_program(all, lab.path());
  };
  CHECK(ask({"db", "verify"}).exit_code == 0);
  const std::string readme = read_text(folder / "README.md");
  int n_questions = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".sql") continue;
    const std::string name = entry.path().stem();
    CAPTURE(name);
    ++n_questions;
    CHECK_THAT(read_text(entry.path()), Catch::Matchers::StartsWith("-- "));
    CHECK_THAT(readme, Contains("`" + name + "`"));
    const auto answer = ask({"query", read_text(entry.path()), "--csv"});
    CHECK(answer.exit_code == 0);
    const std::string expected = read_text(folder / (name + ".csv"));
    CHECK(std::count(expected.begin(), expected.end(), '\n') > 1);
    CHECK(answer.out == expected);
  }
  CHECK(n_questions == 10);
}
