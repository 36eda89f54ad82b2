// The demo's figures against a program written apart, from the equations: recompute.py.

#include "tests/support/catch.hpp"
#include "tests/support/program.hpp"
#include "tests/support/skip.hpp"

using namespace trammel;
using tests::Finished;
using tests::run_program;

namespace {

/// The first python3 that has numpy; none: "".
std::string python_with_numpy(const std::filesystem::path& folder) {
  for (const char* python : {"python3", "/usr/bin/python3"}) {
    if (tests::run_command({python, "-c", "import numpy"}, folder).exit_code == 0) return python;
  }
  return "";
}

}  // namespace

TEST_CASE("every table of the demo's report is what an independent program makes of its readings",
          "[independent]") {
  const tests::TemporaryFolder folder;
  const std::string python = python_with_numpy(folder.path());
  if (python.empty()) return tests::skip("there is no python3 with numpy");
  const auto must = [&](const std::vector<std::string>& words) {
    const Finished done = run_program(words, folder.path());
    CAPTURE(done.err);
    REQUIRE(done.exit_code == 0);
    return done.out;
  };
  must({"demo", "--db", "demo.db"});
  must({"campaign", "export", "paper", "--db", "demo.db", "--out", "paper"});
  must({"report", "paper", "--db", "demo.db", "--json", "--out", "report.json"});
  const std::string here = tests::source_folder();
  const Finished own =
      tests::run_command({python, here + "/tests/independent/recompute.py", "paper", "report.json",
                          here + "/examples/paper/protocol.json"},
                         folder.path());
  INFO(own.out << own.err);
  CHECK(own.exit_code == 0);
  CHECK(own.out.find("figures recomputed, 0 differ") != std::string::npos);

  // A control: one figure changed in its ninth digit is found.
  const Finished changed = tests::run_command({python, "-c",
                                               "import json; r = json.load(open('report.json')); "
                                               "r['tables'][0]['before']['mean'] *= 1 + 1e-7; "
                                               "json.dump(r, open('report.json', 'w'))"},
                                              folder.path());
  REQUIRE(changed.exit_code == 0);
  const Finished found =
      tests::run_command({python, here + "/tests/independent/recompute.py", "paper", "report.json",
                          here + "/examples/paper/protocol.json"},
                         folder.path());
  CHECK(found.exit_code == 1);
  CHECK(found.out.find("1 differ") != std::string::npos);
}
