// Bad input of a campaign, walked through the real program: answered in words, with the right code.

#include <fmt/format.h>

#include "core/mechanism/inverse.hpp"
#include "core/statistics/random.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using tests::Finished;
using tests::run_program;
using tests::TemporaryFolder;

namespace {

const std::vector<std::string> kStages = {"lsq", "geometry", "idw",    "rbf",
                                          "gp",  "hybrid",   "contest"};

struct Row {
  Pose target;
  const char* set = "identify";
  Eigen::Vector3d error = Eigen::Vector3d::Zero();
};

/// A campaign of `rows` on the paper's robot; `tracker` is the JSON of its sigmas, or empty.
void write_campaign(const TemporaryFolder& folder, const std::vector<Row>& rows,
                    const std::string& tracker) {
  std::string json = tests::read_text(tests::source_folder() +
                                      "/tests/support/campaigns/drive-error/campaign.json");
  const auto from = json.find("\"tracker\""), to = json.find("\"readings\"");
  json.replace(from, to - from, tracker);
  folder.write("campaign.json", json);
  std::string csv =
      "seq,set,epoch,target_x_mm,target_y_mm,target_phi_deg,cmd_l1_mm,cmd_l2_mm,cmd_l3_mm,"
      "from_l1_mm,from_l2_mm,from_l3_mm,x_mm,y_mm,phi_deg,time_s,temp_degc\n";
  int seq = 0;
  Displacements from_mm = inverse(paper_mechanism().geometry, Pose{}).l_mm;
  for (const Row& row : rows) {
    const Displacements l = inverse(paper_mechanism().geometry, row.target).l_mm;
    ++seq;
    csv += fmt::format(
        "{},{},1,{},{},{},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{},{},{},{},20\n", seq, row.set,
        row.target.x_mm, row.target.y_mm, deg_from_rad(row.target.phi_rad), l[0], l[1], l[2],
        from_mm[0], from_mm[1], from_mm[2], row.target.x_mm + row.error[0],
        row.target.y_mm + row.error[1], deg_from_rad(row.target.phi_rad + row.error[2]), 20 * seq);
    from_mm = l;
  }
  folder.write("readings.csv", csv);
}

const std::string kTracker = "\"tracker\": {\"sigma_xy_mm\": 0.01, \"sigma_phi_deg\": 0.004},\n ";

Eigen::Vector3d noise(Random& random) {
  return {0.01 * random.normal(), 0.01 * random.normal(), rad_from_deg(0.004) * random.normal()};
}

std::vector<Row> grid(int n, Random& random) {
  std::vector<Row> rows;
  for (int k = 0; k < n; ++k) {
    rows.push_back({{random.uniform(-90, 90), random.uniform(-90, 90), 0}});
    rows.back().error = noise(random) + Eigen::Vector3d(0.001 * rows.back().target.x_mm, 0.02, 0);
  }
  return rows;
}

/// Whatever the answer is: 0 with figures, or 4 with words on stderr; never a crash, NaN or "inf".
Finished answered(const TemporaryFolder& folder, const std::string& stage) {
  INFO(stage);
  const Finished f = run_program({"calibrate", stage, "drive-error"}, folder.path());
  INFO(f.err);
  CHECK((f.exit_code == 0 || f.exit_code == 4));
  CHECK((f.exit_code == 0) == !f.out.empty());
  CHECK(f.out.find("nan") == std::string::npos);
  CHECK(f.out.find("inf") == std::string::npos);
  if (f.exit_code == 4) CHECK(f.err.size() > 30);
  return f;
}

void import(const TemporaryFolder& folder) {
  const Finished f = run_program({"campaign", "import", "."}, folder.path());
  INFO(f.err);
  REQUIRE(f.exit_code == 0);
}

}  // namespace

TEST_CASE("fewer equations than rank: what is not identified is said", "[bad-input]") {
  Random random(501);
  const TemporaryFolder folder;
  write_campaign(folder, grid(3, random), kTracker);
  import(folder);
  for (const std::string& stage : kStages) answered(folder, stage);
  CHECK_THAT(answered(folder, "lsq").out, Contains("rank 9 of 18"));
  CHECK_THAT(answered(folder, "geometry").out, Contains("rank") && Contains("are not"));
  CHECK_THAT(answered(folder, "contest").err, Contains("too few readings"));
}

TEST_CASE("all points in one place: maps refuse, models say what they cannot know", "[bad-input]") {
  Random random(502);
  const TemporaryFolder folder;
  std::vector<Row> rows(12, Row{{20, 30, 0}});
  for (Row& row : rows) row.error = noise(random);
  write_campaign(folder, rows, kTracker);
  import(folder);
  for (const std::string& stage : kStages) answered(folder, stage);
  for (const std::string stage : {"rbf", "gp", "hybrid"}) {
    INFO(stage);
    CHECK(answered(folder, stage).exit_code == 4);
  }
  CHECK_THAT(answered(folder, "geometry").out, Contains("rank 3 of 21"));
  CHECK(run_program({"assess", "drive-error"}, folder.path()).exit_code == 0);
}

TEST_CASE("a sigma of zero is refused at the door, with its field", "[bad-input]") {
  Random random(503);
  for (const std::string field : {"sigma_xy_mm", "sigma_phi_deg"}) {
    const TemporaryFolder folder;
    std::string tracker = kTracker;
    const auto at = tracker.find(field) + field.size() + 3;
    tracker.replace(at, tracker.find_first_of(",}", at) - at, "0");
    write_campaign(folder, grid(20, random), tracker);
    const Finished f = run_program({"campaign", "import", ".", "--json"}, folder.path());
    CHECK(f.exit_code == 4);
    CHECK_THAT(f.err, Contains(field));
  }
}

TEST_CASE("no sigma and no repeat is refused; one repeat is used and its thinness said",
          "[bad-input]") {
  Random random(504);
  const TemporaryFolder none;
  std::vector<Row> rows = grid(40, random);
  write_campaign(none, rows, "");
  import(none);
  for (const std::string stage : {"lsq", "geometry", "hybrid", "contest"}) {
    const Finished f = answered(none, stage);
    CHECK(f.exit_code == 4);
    CHECK_THAT(f.err, Contains("how well a reading is known"));
  }
  CHECK_THAT(run_program({"assess", "drive-error"}, none.path()).out, Contains("no floor"));

  const TemporaryFolder one;
  rows.push_back(rows.back());
  rows.back().error += noise(random);
  rows[39].target = rows[40].target = rows[38].target;  // arrived from the same side, twice
  write_campaign(one, rows, "");
  import(one);
  const Finished assessed = run_program({"assess", "drive-error"}, one.path());
  CHECK(assessed.exit_code == 0);
  CHECK_THAT(assessed.out, Contains("degrees of freedom: 1"));
}

TEST_CASE("a constant column has no R^2 and no length scale, and says so without NaN",
          "[bad-input]") {
  const TemporaryFolder folder;
  Random random(505);
  std::vector<Row> rows = grid(40, random);
  for (Row& row : rows) row.error.setZero();  // the same joint error everywhere: none
  write_campaign(folder, rows, kTracker);
  import(folder);
  for (const std::string& stage : kStages) CHECK(answered(folder, stage).exit_code == 0);
  const Finished json = run_program({"calibrate", "rbf", "drive-error", "--json"}, folder.path());
  CHECK(json.exit_code == 0);
  const Finished report = run_program({"assess", "drive-error", "--job", "1"}, folder.path());
  CHECK(report.exit_code == 0);
  CHECK(report.out.find("nan") == std::string::npos);
}

TEST_CASE("validation points that were fitted count as in-sample, and the answer says so",
          "[bad-input]") {
  const TemporaryFolder folder;
  Random random(506);
  std::vector<Row> rows = grid(30, random);
  for (int k = 0; k < 10; ++k) {
    rows.push_back(rows[static_cast<std::size_t>(k)]);
    rows.back().set = "validate";
    rows.back().error = noise(random);
  }
  write_campaign(folder, rows, kTracker);
  import(folder);
  for (const std::string stage : {"lsq", "idw", "gp"}) {
    CHECK_THAT(answered(folder, stage).out,
               Contains("10 of 10 validation points stand where the correction was fitted") &&
                   Contains("nothing of these readings is held out") && !Contains("(held-out)"));
  }
}

TEST_CASE("100,000 points: answered or refused in words, within the memory of a small machine",
          "[bad-input]") {
  const TemporaryFolder folder;
  Random random(507);
  write_campaign(folder, grid(100000, random), kTracker);
  import(folder);
  for (const std::string stage : {"gp", "hybrid", "idw", "contest"}) {
    const Finished f = answered(folder, stage);
    CHECK(f.exit_code == 4);
    CHECK_THAT(f.err, Contains("too many"));
  }
  CHECK(answered(folder, "lsq").exit_code == 0);
}
