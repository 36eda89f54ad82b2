// The built program, as a user meets it.

#include <nlohmann/json.hpp>

#include "tests/support/catch.hpp"
#include "tests/support/in_process.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using tests::Finished;
using tests::kDriveError;
using tests::run_program;
using tests::TemporaryFolder;

namespace {

/// A folder with a copy of the campaign whose file `name` has `from` replaced by `to`.
void broken_campaign(const TemporaryFolder& folder, const std::string& name,
                     const std::string& from, const std::string& to) {
  for (const char* file : {"campaign.json", "readings.csv"}) {
    std::string text = tests::read_text(kDriveError + "/" + file);
    if (file == name) {
      REQUIRE(text.find(from) != std::string::npos);
      text.replace(text.find(from), from.size(), to);
    }
    folder.write(file, text);
  }
}

}  // namespace

TEST_CASE("version and help are data on stdout, and help lists the exit codes", "[cli]") {
  const TemporaryFolder folder;
  const Finished version = run_program({"--version"}, folder.path());
  CHECK(version.exit_code == 0);
  CHECK_THAT(version.out, Contains("trammel 0."));
  CHECK(version.err.empty());
  for (std::vector<std::string> words :
       std::vector<std::vector<std::string>>{{}, {"campaign"}, {"campaign", "import"}, {"man"}}) {
    words.emplace_back("--help");
    const Finished help = run_program(words, folder.path());
    CAPTURE(words);
    CHECK(help.exit_code == 0);
    CHECK(help.err.empty());
    CHECK_THAT(help.out, Contains("Exit codes:") && Contains("130  interrupted"));
    CHECK(help.out == tests::run_here(words).out);  // so that others can ask it there
  }
}

TEST_CASE("a wrong command line ends with 2, nothing on stdout, and says what was meant", "[cli]") {
  const TemporaryFolder folder;
  struct Wrong {
    std::vector<std::string> words;
    const char* said;
  };
  const std::vector<Wrong> all = {
      {{}, "needs a command"},
      {{"reprot"}, "did you mean report?"},
      {{"campaign", "imprt"}, "did you mean import?"},
      {{"campaign"}, "one of"},
      {{"report", "x", "--jsno"}, "did you mean --json?"},
      {{"report"}, "CAMPAIGN is required"},
      {{"xylophone"}, "known:"},
  };
  for (const Wrong& wrong : all) {
    const Finished finished = run_program(wrong.words, folder.path());
    CAPTURE(wrong.words);
    CHECK(finished.exit_code == 2);
    CHECK(finished.out.empty());
    CHECK_THAT(finished.err, Contains(wrong.said));
  }
}

TEST_CASE("with --json an error is one object on stderr", "[cli]") {
  const TemporaryFolder folder;
  const Finished missing = run_program({"campaign", "import", "nowhere", "--json"}, folder.path());
  CHECK(missing.exit_code == 3);
  CHECK(missing.out.empty());
  const nlohmann::json error = nlohmann::json::parse(missing.err);
  CHECK(error.at("schema") == "trammel/error/1");
  CHECK(error.at("kind") == "not_found");
  CHECK(error.at("exit_code") == 3);
  CHECK(error.at("file") == "nowhere");
  const Finished usage = run_program({"reprot", "--json"}, folder.path());
  CHECK(nlohmann::json::parse(usage.err).at("kind") == "usage");
}

TEST_CASE("bad input ends with 4, names file, line and field, and stores nothing", "[cli]") {
  struct Bad {
    const char* file;
    const char* from;
    const char* to;
    const char* field;
    int line;
  };
  const std::vector<Bad> all = {
      {"readings.csv", "temp_degc", "temp_degc2", "temp_degc2", 1},  // unknown column
      {"readings.csv", "10.00460", "NaN", "x_mm", 2},
      {"readings.csv", "10.00460", "ten", "x_mm", 2},
      {"readings.csv", "\n2,identify", "\n1,identify", "seq", 3},
      {"readings.csv", ",20.0000,", ",2000.0,", "target", 3},
      {"campaign.json", "\"simulated\"", "17", "kind", 4},
      {"campaign.json", "430.0", "\"430\"", "mechanism.chains[0].S_mm", 0},
  };
  for (const Bad& bad : all) {
    CAPTURE(bad.to);
    const TemporaryFolder folder;
    broken_campaign(folder, bad.file, bad.from, bad.to);
    const Finished finished = run_program({"campaign", "import", ".", "--json"}, folder.path());
    CHECK(finished.exit_code == 4);
    CHECK(finished.out.empty());
    const nlohmann::json error = nlohmann::json::parse(finished.err);
    CHECK_THAT(error.at("file").get<std::string>(), Contains(bad.file));
    CHECK(error.at("field") == bad.field);
    CHECK((bad.line == 0 ? error.at("line") > 0 : error.at("line") == bad.line));
    CHECK_FALSE(std::filesystem::exists(folder.path() / "trammel.db"));
  }
}

TEST_CASE("a database of another program is refused with 8 and left as it is", "[cli]") {
  const TemporaryFolder folder;
  folder.write("trammel.db", "this is no database, but a letter to my aunt, and long enough");
  const Finished finished = run_program({"campaign", "import", kDriveError}, folder.path());
  CHECK(finished.exit_code == 8);
  CHECK_THAT(tests::read_text(folder.path() / "trammel.db"), Contains("my aunt"));
}

TEST_CASE("output that a full disk loses ends with 1, not with half of it and 0", "[cli]") {
  const TemporaryFolder folder;
  REQUIRE(run_program({"campaign", "import", kDriveError}, folder.path()).exit_code == 0);
  const std::string program = tests::build_folder() + "/trammel ";
  for (const char* words : {"--version", "--help", "man", "campaign list", "report drive-error",
                            "report drive-error --json", "query v_accuracy"}) {
    CAPTURE(words);
    const auto to = [&](const char* sink) {
      return tests::run_command({"sh", "-c", program + words + " >" + sink}, folder.path());
    };
    const Finished lost = to("/dev/full");
    CHECK(lost.exit_code == 1);
    CHECK_THAT(lost.err, Contains("stdout"));
    CHECK(to("/dev/null").exit_code == 0);
  }
}

TEST_CASE("a page is never written over the laboratory it was made of", "[cli]") {
  const TemporaryFolder folder;
  REQUIRE(run_program({"campaign", "import", kDriveError}, folder.path()).exit_code == 0);
  const std::string before = tests::read_text(folder.path() / "trammel.db");
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"report", "drive-error", "--html", "trammel.db"},
        {"report", "drive-error", "--html", "trammel.db", "--overwrite"},
        {"plan", "create", "paper-80", "--out", "trammel.db", "--overwrite"}}) {
    CHECK(run_program(words, folder.path()).exit_code == 4);
    CHECK(tests::read_text(folder.path() / "trammel.db") == before);
  }
}

TEST_CASE("importing twice stores once, and stdout holds data only", "[cli]") {
  const TemporaryFolder folder;
  const Finished first = run_program({"campaign", "import", kDriveError, "--json"}, folder.path());
  const Finished again = run_program({"campaign", "import", kDriveError, "--json"}, folder.path());
  CHECK(first.exit_code == 0);
  CHECK(nlohmann::json::parse(first.out).at("schema") == "trammel/campaign-import/1");
  CHECK(nlohmann::json::parse(first.out).at("already_stored") == false);
  CHECK(nlohmann::json::parse(again.out).at("already_stored") == true);
  const Finished text = run_program({"campaign", "import", kDriveError}, folder.path());
  CHECK_THAT(text.err, Contains("next: trammel"));
  CHECK(text.out.find("next:") == std::string::npos);
  CHECK(text.out.find('\x1b') == std::string::npos);
}

TEST_CASE("an imported campaign is exported with the same numbers", "[cli]") {
  const TemporaryFolder folder;
  REQUIRE(run_program({"campaign", "import", kDriveError}, folder.path()).exit_code == 0);
  REQUIRE(
      run_program({"campaign", "export", "drive-error", "--out", "a"}, folder.path()).exit_code ==
      0);
  REQUIRE(run_program({"--db", "2.db", "campaign", "import", "a"}, folder.path()).exit_code == 0);
  REQUIRE(run_program({"--db", "2.db", "campaign", "export", "drive-error", "--out", "b"},
                      folder.path())
              .exit_code == 0);
  CHECK(tests::read_text(folder.path() / "a/readings.csv") ==
        tests::read_text(folder.path() / "b/readings.csv"));
  CHECK(tests::read_text(folder.path() / "a/campaign.json") ==
        tests::read_text(folder.path() / "b/campaign.json"));
}
