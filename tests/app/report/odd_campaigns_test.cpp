// Campaigns that are odd in one column are reported all the same.

#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/support/catch.hpp"
#include "tests/support/in_process.hpp"
#include "tests/support/program.hpp"

using namespace trammel;
using tests::Finished;

namespace {

/// The drive error as files to be changed, and a database.
struct Odd {
  tests::TemporaryFolder folder;
  std::filesystem::path files = folder.path() / "odd";
  Odd() { std::filesystem::copy(tests::kDriveError, files); }

  [[nodiscard]] Finished run(std::vector<std::string> words) const {
    words.insert(words.end(), {"--db", "a.db", "--quiet"});
    return tests::run_here(words, folder.path());
  }
  void check_runs(const std::vector<std::string>& words) const {
    const Finished done = run(words);
    CAPTURE(words, done.err);
    CHECK(done.exit_code == 0);
  }
  /// Cells of each row of the readings, from row 0 on.
  void change(const std::string& column,
              const std::function<void(std::vector<std::string>& cells, std::size_t at, int row)>&
                  what) const {
    std::istringstream in(tests::read_text(files / "readings.csv"));
    std::string out;
    std::size_t at = 0;
    int row = -1;
    for (std::string line; std::getline(in, line); ++row) {
      std::vector<std::string> cells;
      std::istringstream cut(line);
      for (std::string cell; std::getline(cut, cell, ',');) cells.push_back(cell);
      if (row < 0) {
        at = static_cast<std::size_t>(std::ranges::find(cells, column) - cells.begin());
        REQUIRE(at < cells.size());
      }
      what(cells, at, row);
      for (std::size_t k = 0; k < cells.size(); ++k) out += (k == 0 ? "" : ",") + cells[k];
      out += "\n";
    }
    std::ofstream(files / "readings.csv") << out;
  }
};

}  // namespace

TEST_CASE("a 3-PRR of which no orientation was read is reported and assessed", "[report]") {
  const Odd odd;
  auto campaign = nlohmann::json::parse(tests::read_text(odd.files / "campaign.json"));
  campaign["format"] = "campaign/2";
  campaign["measured"] = {"x", "y"};
  campaign["tracker"].erase("sigma_phi_deg");
  auto& mechanism = campaign["mechanism"];
  const nlohmann::json drive = {
      {"type", "linear"}, {"lead_mm", 10.0}, {"l_min_mm", 0.0}, {"l_max_mm", 600.0}};
  mechanism = {{"type", "3-PRR"},
               {"home", mechanism.at("home")},
               {"chains", mechanism.at("chains")},
               {"drives", {drive, drive, drive}}};
  std::ofstream(odd.files / "campaign.json") << campaign.dump();
  odd.change("phi_deg", [](auto& cells, std::size_t at, int) {
    cells.erase(cells.begin() + static_cast<std::ptrdiff_t>(at));
  });
  odd.check_runs({"campaign", "import", "odd"});
  odd.check_runs({"calibrate", "geometry", "drive-error"});
  odd.check_runs({"report", "drive-error"});
  odd.check_runs({"assess", "drive-error", "--job", "1"});
}

TEST_CASE("one reading where no such robot can be ends no report, and is named", "[report]") {
  const Odd odd;
  odd.change("x_mm", [](auto& cells, std::size_t at, int row) {
    if (row == 30) cells[at] = "99999.999";
  });
  odd.check_runs({"campaign", "import", "odd"});
  odd.check_runs({"calibrate", "idw", "drive-error", "--without-suspects"});
  odd.check_runs({"report", "drive-error"});
  odd.check_runs({"assess", "drive-error", "--job", "1"});
  odd.check_runs({"diagnose", "drive-error"});
  CHECK_THAT(odd.run({"report", "drive-error"}).out, Catch::Contains("seq 31"));
}

TEST_CASE("a wrong reading that judges a correction is named by its calibration", "[report]") {
  const Odd odd;
  odd.change("x_mm", [](auto& cells, std::size_t at, int row) {
    if (cells[1] == "validate" && row % 20 == 0)
      cells[at] = std::to_string(std::stod(cells[at]) + 5);
  });
  odd.check_runs({"campaign", "import", "odd"});
  for (const char* method : {"lsq", "idw", "geometry"}) {
    const Finished done = odd.run({"calibrate", method, "drive-error"});
    CAPTURE(method, done.err);
    CHECK_THAT(done.out, Catch::Contains("suspect reading, which judges the correction"));
  }
}

TEST_CASE("targets a whole turn off change no figure", "[report]") {
  const Odd as_it_is, turned;
  turned.change("target_phi_deg", [](auto& cells, std::size_t at, int row) {
    if (row >= 0 && row % 5 == 0) cells[at] = std::to_string(std::stod(cells[at]) + 360);
  });
  std::vector<std::string> printed;
  for (const Odd* odd : {&as_it_is, &turned}) {
    odd->check_runs({"campaign", "import", "odd"});
    std::string text;
    for (const char* method : {"lsq", "geometry", "idw"}) {
      const Finished done = odd->run({"calibrate", method, "drive-error"});
      CAPTURE(method, done.err);
      CHECK(done.exit_code == 0);
      text += done.out.substr(done.out.find("predicted after compensation"));
    }
    printed.push_back(text);
  }
  CHECK(printed[0] == printed[1]);
}
