// Other tools read a laboratory: examples/python and examples/octave print what the program does.

#include <algorithm>
#include <sstream>

#include "tests/support/catch.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"
#include "tests/support/skip.hpp"

using namespace trammel;

namespace {

const std::string kExamples = tests::source_folder() + "/examples/";

bool there(const std::string& program) {
  return tests::run_command({"sh", "-c", "command -v " + program}, "/").exit_code == 0;
}

/// A laboratory of the test's own: SQLite keeps files beside one that is open.
struct Copy {
  tests::TemporaryFolder folder;
  Copy() {
    std::filesystem::copy_file(kExamples + "queries/laboratory.sqlite3",
                               folder.path() / "laboratory.db");
  }
  /// "measure-48: 48 readings, mean 0.2586 mm, max 0.4419 mm", from a question of our own.
  [[nodiscard]] std::string expected(const std::string& session) const {
    const auto asked = tests::run_program(
        {"query", "--db", "laboratory.db", "--csv",
         "SELECT count(*), printf('%.4f', avg(position_mm)), printf('%.4f', max(position_mm)) FROM "
         "v_point_error WHERE excluded IS NULL AND session = '" +
             session + "'"},
        folder.path());
    std::string row = asked.out.substr(asked.out.find('\n') + 1);
    for (char& c : row) c = c == ',' || c == '\n' ? ' ' : c;
    std::istringstream in(row);
    std::string n, mean, max;
    in >> n >> mean >> max;
    return session + ": " + n + " readings, mean " + mean + " mm, max " + max + " mm\n";
  }
};

}  // namespace

TEST_CASE("Python reads a laboratory by itself and finds what the program finds",
          "[cli][examples]") {
  if (!there("python3")) return tests::skip("python3 is not here");
  const Copy laboratory;
  for (const char* session : {"measure-48", "measure-80-lsq"}) {
    const auto done = tests::run_command(
        {"python3", kExamples + "python/point_errors.py", "laboratory.db", session},
        laboratory.folder.path());
    INFO(done.err);
    CHECK(done.exit_code == 0);
    CHECK_THAT(done.out, Contains(laboratory.expected(session)));
    CHECK(std::count(done.out.begin(), done.out.end(), '\n') > 8);  // and a map
  }
  CHECK_THAT(tests::read_text(kExamples + "python/README.md"),
             Contains(laboratory.expected("measure-48")));
  for (const std::vector<std::string>& wrong : std::vector<std::vector<std::string>>{
           {"laboratory.db", "nobody"}, {"nowhere.db", "measure-48"}, {"laboratory.db"}}) {
    std::vector<std::string> words = {"python3", kExamples + "python/point_errors.py"};
    words.insert(words.end(), wrong.begin(), wrong.end());
    const auto refused = tests::run_command(words, laboratory.folder.path());
    CAPTURE(words, refused.err);
    CHECK(refused.exit_code == 1);
    CHECK(std::count(refused.err.begin(), refused.err.end(), '\n') == 1);  // no traceback
  }
}

TEST_CASE("Octave finds the same through a table", "[cli][examples]") {
  if (!there("octave-cli")) return tests::skip("octave is not here");
  const Copy laboratory;
  const std::string path = "PATH=" + tests::build_folder() + ":/usr/bin:/bin";
  const auto done =
      tests::run_command({"env", path, "octave-cli", "--no-gui", "--norc", "--quiet",
                          kExamples + "octave/point_errors.m", "laboratory.db", "measure-48"},
                         laboratory.folder.path());
  INFO(done.err);
  CHECK(done.exit_code == 0);
  CHECK_THAT(done.out, Contains(laboratory.expected("measure-48")));
}

TEST_CASE("a laboratory of an older version is reported in text, JSON and as a page",
          "[examples][report]") {
  const Copy laboratory;
  for (const std::vector<std::string>& sink :
       {std::vector<std::string>{}, {"--json"}, {"--html", "page.html"}, {"--tolerance", "0.5"}}) {
    std::vector<std::string> words{"report", "paper", "--db", "laboratory.db"};
    words.insert(words.end(), sink.begin(), sink.end());
    const Finished report = tests::run_program(words, laboratory.folder.path());
    INFO(report.err);
    CHECK((report.exit_code == 0 || report.exit_code == 5));  // 5: the tolerance is not met
  }
}
