#include "app/files/campaign_file.hpp"

#include "app/files/numbers.hpp"
#include "app/files/readings_csv.hpp"
#include "core/error.hpp"
#include "core/mechanism/inverse.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/csv.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using trammel::tests::read_text;
using trammel::tests::TemporaryFolder;

namespace {

const std::string kDriveError = tests::source_folder() + "/tests/support/campaigns/drive-error";

const char* const kHead =
    R"({"format": "campaign/1", "name": "t", "kind": "real",
 "mechanism": {"type": "3-PRR", "screw_lead_mm": 10, "limits": {"l_max_mm": 600}, "chains": [
  {"alpha_deg": 270, "beta_deg": 30, "r_mm": 100, "S_mm": 430, "R_mm": 733},
  {"alpha_deg": 30, "beta_deg": 150, "r_mm": 100, "S_mm": 430, "R_mm": 733},
  {"alpha_deg": 150, "beta_deg": 270, "r_mm": 100, "S_mm": 430, "R_mm": 733}]},
 "facts": {"operator": "A. \"B\", <C>"},
 "readings": "readings.csv"})";

const std::string kColumns =
    "seq,target_x_mm,target_y_mm,target_phi_deg,cmd_l1_mm,cmd_l2_mm,cmd_l3_mm,x_mm,y_mm,phi_deg";

CampaignFile read(const std::string& csv, const std::string& head = kHead) {
  const TemporaryFolder folder;
  folder.write("campaign.json", head);
  folder.write("readings.csv", csv);
  return read_campaign(folder.path());
}

ErrorText error_of(const std::string& csv, const std::string& head = kHead) {
  try {
    (void)read(csv, head);
  } catch (const InputError& error) {
    return error.text();
  }
  FAIL("nothing was refused");
  return {};
}

void check_same(const CampaignFile& a, const CampaignFile& b) {
  CHECK(a.campaign.name == b.campaign.name);
  CHECK(a.campaign.simulated == b.campaign.simulated);
  CHECK(to_vector(mechanism_of(a.campaign.machine).geometry) ==
        to_vector(mechanism_of(b.campaign.machine).geometry));
  CHECK(a.campaign.facts == b.campaign.facts);
  CHECK(a.extra_columns == b.extra_columns);
  CHECK(a.extras == b.extras);
  REQUIRE(a.campaign.readings.size() == b.campaign.readings.size());
  for (std::size_t k = 0; k < a.campaign.readings.size(); ++k) {
    const Reading &p = a.campaign.readings[k], &q = b.campaign.readings[k];
    CHECK(p.seq == q.seq);
    CHECK(p.set == q.set);
    CHECK(p.target == q.target);
    CHECK(p.measured == q.measured);
    CHECK(p.conditions.cmd_mm == q.conditions.cmd_mm);
    CHECK(p.conditions.from_mm == q.conditions.from_mm);
    CHECK(p.conditions.epoch == q.conditions.epoch);
    CHECK(p.conditions.time_s == q.conditions.time_s);
    CHECK(p.conditions.temp_degc == q.conditions.temp_degc);
  }
}

}  // namespace

TEST_CASE("import then export then import gives the same numbers bit for bit", "[exchange]") {
  const CampaignFile first = read_campaign(kDriveError);
  CHECK(first.campaign.readings.size() == 152);
  REQUIRE(first.campaign.tracker.has_value());
  const TemporaryFolder folder;
  write_campaign(first, folder.path() / "out");
  check_same(first, read_campaign(folder.path() / "out"));
}

TEST_CASE("export writes the numbers that stood in the imported file", "[exchange]") {
  const TemporaryFolder folder;
  write_campaign(read_campaign(kDriveError), folder.path());
  std::filesystem::copy_file(kDriveError + "/readings.csv", folder.path() / "in.csv");
  std::ifstream in(folder.path() / "in.csv"), out(folder.path() / "readings.csv");
  std::string a, b;
  int n_rows = 0;
  while (std::getline(in, a)) {
    REQUIRE(std::getline(out, b));
    if (!a.empty() && a.back() == '\r') a.pop_back();
    std::istringstream cells_a(a), cells_b(b);
    for (std::string x, y; std::getline(cells_a, x, ',');) {
      std::getline(cells_b, y, ',');
      const auto number = parse_number(x);
      CHECK((number ? parse_number(y) == number : x == y));
    }
    ++n_rows;
  }
  CHECK(n_rows == 153);
}

TEST_CASE("x_ columns and facts are kept as they are", "[exchange]") {
  const CampaignFile file = read(kColumns +
                                 ",x_note,x_n\n"
                                 "2,0,0,0,261.8,261.8,261.8,0,0,0,\"a,\"\"b\"\"\",0x1\n"
                                 "1,0,0,0,261.8,261.8,261.8,0,0,0,,\n");
  REQUIRE(file.extra_columns == std::vector<std::string>{"x_note", "x_n"});
  CHECK(file.campaign.readings[0].seq == 1);
  CHECK(file.extras[0].empty());
  CHECK(file.extras[1].at("x_note") == "a,\"b\"");
  const TemporaryFolder folder;
  write_campaign(file, folder.path());
  check_same(file, read_campaign(folder.path() / "campaign.json"));
}

TEST_CASE("formulas in x_ columns leave defused and come back as they were", "[exchange]") {
  const CampaignFile file = read(kColumns +
                                 ",x_note,x_n\n"
                                 "1,0,0,0,261.8,261.8,261.8,0,0,0,'=1+1,-1.5\n"
                                 "2,0,0,0,261.8,261.8,261.8,0,0,0,@SUM(A1),+2\n");
  CHECK(file.extras[0].at("x_note") == "=1+1");
  const TemporaryFolder folder;
  write_campaign(file, folder.path());
  const std::string text = read_text(folder.path() / "readings.csv");
  CHECK_THAT(text, Contains(",'=1+1,-1.5\n") && Contains(",'@SUM(A1),+2\n"));
  check_same(file, read_campaign(folder.path() / "campaign.json"));
}

TEST_CASE("without from columns a move begins where the row before ended, the first at home",
          "[exchange]") {
  const CampaignFile file = read(kColumns +
                                 "\n1,0,0,0,261.8,261.9,262,0,0,0\n"
                                 "2,1,0,0,262,263,261,1,0,0");
  const Mechanism& mechanism = mechanism_of(file.campaign.machine);
  const auto& readings = file.campaign.readings;
  CHECK(readings[0].conditions.from_mm == inverse(mechanism.geometry, mechanism.home).l_mm);
  CHECK(readings[1].conditions.from_mm == readings[0].conditions.cmd_mm);
  CHECK(readings[0].set == ReadingSet::identify);
  CHECK(readings[0].conditions.epoch == 1);
}

TEST_CASE("a measured pose far off is data", "[exchange]") {
  const CampaignFile file = read(kColumns + "\n1,0,0,0,261.8,261.8,261.8,5000,-4000,90\n");
  CHECK(file.campaign.readings[0].measured->x_mm == 5000);
}

TEST_CASE("a bad row is refused with its line, column and field", "[exchange]") {
  struct Bad {
    std::string row;
    int column;
    const char* field;
  };
  const std::vector<Bad> all = {
      {"1,nan,0,0,261.8,261.8,261.8,0,0,0", 3, "target_x_mm"},
      {"1,0,0,0,261.8,0x105,261.8,0,0,0", 15, "cmd_l2_mm"},
      {"1,0,0,0,261.8,261.8,261.8,inf,0,0", 27, "x_mm"},
      {"1,0,0,0,261.8,261.8,261.8,0,zero,0", 29, "y_mm"},
      {"1,0,0,0,261.8,261.8,261.8,0,0,", 31, "phi_deg"},
      {"1,0,0,0,261.8,261.8,,0,0,0", 21, "cmd_l3_mm"},
      {"1,0,0,0,261.8,261.8,261.8,1e999,0,0", 27, "x_mm"},
      {"0,0,0,0,261.8,261.8,261.8,0,0,0", 1, "seq"},
      {"1.5,0,0,0,261.8,261.8,261.8,0,0,0", 1, "seq"},
      {"1,900,0,0,261.8,261.8,261.8,0,0,0", 3, "target"},
      {"1,0,0,0,261.8,261.8,700,0,0,0", 21, "cmd_l3_mm"},
      {"1,0,0,0,0,600,600,0,0,0", 9, "cmd_l1_mm"},
      {"1,0,0,0,261.8,261.8,261.8,0,0", 29, "phi_deg"},
  };
  for (const Bad& bad : all) {
    CAPTURE(bad.row);
    const ErrorText error = error_of(kColumns + "\n7,0,0,0,261.8,261.8,261.8,0,0,0\n" + bad.row);
    CHECK_THAT(error.where.file, Contains("readings.csv"));
    CHECK(error.where.line == 3);
    CHECK(error.where.column == bad.column);
    CHECK(error.where.field == bad.field);
  }
}

TEST_CASE("a repeated seq, an unknown column and a measured predict row are refused",
          "[exchange]") {
  const std::string row = "1,0,0,0,261.8,261.8,261.8,0,0,0";
  const ErrorText repeated = error_of(kColumns + "\n" + row + "\n" + row);
  CHECK(repeated.where.line == 3);
  CHECK(repeated.where.field == "seq");
  const ErrorText unknown = error_of(kColumns + ",colour\n" + row + ",red");
  CHECK_THAT(unknown.what, Contains("unknown column 'colour'"));
  CHECK(unknown.where.line == 1);
  CHECK(unknown.where.column == static_cast<int>(kColumns.size()) + 2);
  const ErrorText missing = error_of("seq,x_mm\n1,2");
  CHECK_THAT(missing.what, Contains("column is missing"));
  CHECK(missing.where.field == "target_x_mm");
  CHECK(error_of(kColumns + ",set\n" + row + ",predict").where.field == "x_mm");
  CHECK(error_of(kColumns + ",set\n" + row + ",fit").where.field == "set");
  CHECK(error_of(kColumns + ",from_l1_mm\n" + row + ",1").where.field == "from_l2_mm");
}

TEST_CASE("a bad campaign.json is refused by its path", "[exchange]") {
  const std::string csv = kColumns + "\n";
  const auto with = [](const std::string& from, const std::string& to) {
    std::string head = kHead;
    head.replace(head.find(from), from.size(), to);
    return head;
  };
  CHECK(error_of(csv, with("\"real\"", "\"true\"")).where.field == "kind");
  CHECK(error_of(csv, with("campaign/1", "campaign/9")).where.field == "format");
  CHECK(error_of(csv, with("\"S_mm\": 430", "\"S_mm\": true")).where.field ==
        "mechanism.chains[0].S_mm");
  CHECK(error_of(csv, with("\"S_mm\": 430", "\"S_mm\": -430")).where.line == 3);
  CHECK(error_of(csv, with("\"facts\"", "\"fact\"")).where.field == "fact");
  CHECK(error_of(csv, with("\"facts\"", "\"tracker\"")).where.field == "tracker.operator");
}

TEST_CASE("missing files are not found and name themselves", "[exchange]") {
  const TemporaryFolder folder;
  CHECK_THROWS_AS(read_campaign(folder.path()), NotFoundError);
  CHECK_THROWS_AS(read_campaign(folder.path() / "nowhere"), NotFoundError);
  folder.write("campaign.json", kHead);
  CHECK_THROWS_WITH(read_campaign(folder.path()), Contains("readings.csv"));
}

TEST_CASE("a refused export leaves what was there", "[exchange]") {
  const TemporaryFolder folder;
  const auto blocked = folder.write("file", "old");
  CHECK_THROWS_AS(write_campaign(read_campaign(kDriveError), blocked), StoreError);
  CHECK(read_text(blocked) == "old");
}

namespace {

const char* const kStage =
    R"({"format": "campaign/2", "name": "xy", "kind": "real",
 "mechanism": {"type": "XY",
  "chains": [{"alpha_deg": 0, "gamma_deg": 90}, {"alpha_deg": 90, "gamma_deg": 0}],
  "drives": [{"lead_mm": 5, "l_min_mm": -200, "l_max_mm": 200},
             {"lead_mm": 10, "l_min_mm": -100, "l_max_mm": 100}]},
 "measured": ["x", "y"],
 "tracker": {"sigma_xy_mm": 0.0001},
 "sessions": [{"name": "a", "plan": "grid", "n_points": 4, "held_epochs": [2]}],
 "exclusions": [{"seq": 2, "reason": "bumped"}],
 "readings": "readings.csv"})";

const std::string kStageColumns =
    "seq,session,compensation,role,epoch,target_x_mm,target_y_mm,cmd_l1_mm,cmd_l2_mm,x_mm,y_mm\n";

}  // namespace

TEST_CASE("campaign/2 holds a machine of two drives, its walks and what was left out",
          "[exchange]") {
  const CampaignFile file = read(kStageColumns +
                                     "1,a,,,1,10,20,10,20,10.001,19.999\n"
                                     "2,a,,circle 1,2,30,-5,30,-5,30.002,-5.001\n"
                                     "3,b,lsq,,2,10,20,9.999,20.001,10,20\n",
                                 kStage);
  const Machine& machine = file.campaign.machine;
  CHECK(machine.kind->name == "XY");
  CHECK(machine.drives[1].limits.l_max_mm == 100);
  CHECK(machine.measured == Coordinates{true, true, false});
  REQUIRE(file.sessions.size() == 2);
  CHECK((file.sessions[0].n_points == 4 && file.sessions[0].compensation.empty()));
  CHECK((file.sessions[1].name == "b" && file.sessions[1].compensation == "lsq"));
  CHECK(file.session_of == std::vector<std::size_t>{0, 0, 1});
  CHECK(file.campaign.readings[1].measured->phi_rad == 0);
  // A calibration takes baseline readings that are not left out.
  CHECK(baseline_of(file).readings.size() == 1);
  const TemporaryFolder folder;
  write_campaign(file, folder.path() / "out");
  const CampaignFile again = read_campaign(folder.path() / "out");
  CHECK(again.campaign.machine == machine);
  CHECK(again.roles == file.roles);
  CHECK(again.exclusions == file.exclusions);
  CHECK(again.sessions[0].held_epochs == std::vector<int>{2});
  CHECK(again.campaign.readings[2].conditions.cmd_mm == Displacements(9.999, 20.001, 0));
  CHECK_THAT(read_text(folder.path() / "out" / "readings.csv"),
             !Contains("phi") && !Contains("l3"));
}

TEST_CASE("campaign/2 refuses what contradicts itself or its machine", "[exchange]") {
  const std::string row = "1,a,,,1,10,20,10,20,10.001,19.999\n", two = "2,a,,,1,0,0,0,0,0,0\n";
  // Another correction in one walk; a walk and an exclusion without a reading.
  CHECK_THAT(error_of(kStageColumns + row + "2,a,lsq,,1,0,0,0,0,0,0\n", kStage).what,
             Contains("another correction"));
  CHECK_THAT(error_of(kStageColumns + "1,b,,,1,0,0,0,0,0,0\n2,b,,,1,0,0,0,0,0,0\n", kStage).what,
             Contains("session without a reading"));
  CHECK(error_of(kStageColumns + row, kStage).where.point == "seq 2");
  // Columns of what the machine has not, or does not measure.
  CHECK_THAT(error_of("phi_deg," + kStageColumns + "0," + row + "0," + two, kStage).what,
             Contains("phi_deg"));
  CHECK_THAT(error_of("cmd_l3_mm," + kStageColumns + "0," + row, kStage).what,
             Contains("cmd_l3_mm"));
  // Beyond a drive's own limits: 150 mm is in reach of the first drive alone.
  CHECK_THAT(error_of(kStageColumns + "1,a,,,1,0,150,0,150,0,150\n" + two, kStage).what,
             Contains("limits"));
  // campaign/1 knows no walks.
  CHECK_THAT(error_of(kColumns + ",session\n1,0,0,0,261.8,261.8,261.8,0,0,0,a\n").what,
             Contains("session"));
}

TEST_CASE("rows of campaign/1 that were measured under a correction are no baseline",
          "[exchange]") {
  CampaignFile file = read_campaign(kDriveError);
  const std::size_t n = file.campaign.readings.size();
  CHECK(file.sessions.size() == 1);
  const TemporaryFolder folder;
  // The last forty rows' first command is 0.08 mm from the nominal one.
  const auto to = [&](std::size_t first, double by_mm) {
    CampaignFile moved = file;
    moved.format = 1;
    for (std::size_t k = first; k < n; ++k)
      moved.campaign.readings[k].conditions.cmd_mm[0] += by_mm;
    folder.write("readings.csv", readings_csv(moved));
    folder.write("campaign.json", read_text(kDriveError + "/campaign.json"));
    return read_campaign(folder.path());
  };
  const CampaignFile some = to(n - 40, 0.08);
  REQUIRE(some.sessions.size() == 2);
  CHECK_FALSE(some.sessions[1].compensation.empty());
  CHECK(baseline_of(some).readings.size() == n - 40);
  CHECK(to(n - 40, 0.001).sessions.size() == 1);  // an encoder's count
  CHECK(to(0, 0.08).sessions.size() == 1);        // all: commands of another model
}
