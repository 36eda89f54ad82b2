#include "app/files/points_look.hpp"

#include <fmt/format.h>
#include <cstdlib>
#include <filesystem>

#include "core/error.hpp"
#include "core/statistics/random.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/skip.hpp"

using namespace trammel;

namespace {

/// Public data that is not ours to hand on: the folder that TRAMMEL_REAL_DATA names.
std::optional<std::string> real_data(const std::string& file) {
  const char* folder = std::getenv("TRAMMEL_REAL_DATA");
  if (folder != nullptr && std::filesystem::exists(std::filesystem::path(folder) / file)) {
    return (std::filesystem::path(folder) / file).string();
  }
  tests::skip("set TRAMMEL_REAL_DATA to the folder that holds " + file);
  return std::nullopt;
}

std::vector<int> lines_of(const std::vector<PlaceLook::MissedRow>& rows) {
  std::vector<int> lines;
  for (const auto& row : rows) lines.push_back(row.line);
  return lines;
}

std::vector<int> lines_of(const std::vector<PlaceLook::Outlier>& rows) {
  std::vector<int> lines;
  for (const auto& row : rows) lines.push_back(row.line);
  return lines;
}

/// One nest 200 times with 15 um, two misses and a ghost.
std::string one_nest() {
  Random random(5);
  std::string text;
  for (int line = 1; line <= 200; ++line) {
    if (line == 17 || line == 90) {
      text += "0 0 0\n";
      continue;
    }
    const double ghost = line == 44 ? 243 : 0;
    const double x = random.normal(), y = random.normal(), z = random.normal();
    text += fmt::format("{:.9e} {:.9e} {:.9e}\n", 2778 + 0.015 * x, -5.6 + 0.015 * y + ghost,
                        -562.9 + 0.015 * z);
  }
  return text;
}

}  // namespace

TEST_CASE("misses and gross outliers of a resting nest are named by line", "[points]") {
  const PointsLook look = look_at(parse_points(one_nest(), "m.txt", {}));
  REQUIRE(look.places.size() == 1);
  const PlaceLook& nest = look.places[0];
  CHECK(nest.n == 197);
  CHECK(lines_of(nest.misses) == std::vector<int>{17, 90});
  CHECK(lines_of(nest.outliers) == std::vector<int>{44});
  CHECK_THAT(nest.outliers[0].distance_mm, WithinAbs(243, 0.1));
  CHECK_THAT(nest.rms_mm, WithinRel(0.015 * std::sqrt(3.0), 0.12));  // five standard errors
  REQUIRE(nest.RP_l_mm);
  CHECK(*nest.RP_l_mm > nest.rms_mm);
}

TEST_CASE("a name that comes back is a place; names that never do leave the group", "[points]") {
  const auto rounds = look_at(parse_points("1,1,1,1\n2,5,5,5\n1,1,1,1\n2,5,5,5\n", "r", {}));
  CHECK(rounds.by == PlaceBy::name);
  CHECK(rounds.places.size() == 2);
  CHECK(rounds.places[1].place == "2");
  CHECK_FALSE(rounds.places[1].RP_l_mm);  // two visits have no repeatability
  const auto counted = look_at(parse_points("J,G,1,1,1,1\nJ,G,2,1,1,1\nJ,H,1,9,9,9\n", "g", {}));
  CHECK(counted.by == PlaceBy::group);
  CHECK(counted.places.size() == 2);
  CHECK(counted.places[0].n == 2);
}

TEST_CASE("rows that go round nests must go round, and in turn", "[points]") {
  const auto file = parse_points("1 1 1\n5 5 5\n1 1 1\n5 5 5\n", "m", {});
  const auto look = look_at(file, {}, 2);
  REQUIRE(look.places.size() == 2);
  CHECK(look.places[1].median_mm.x() == 5);
  CHECK_THROWS_WITH(look_at(file, {}, 3), Contains("4 rows"));
  const auto named = parse_points("a,1,1,1\nb,5,5,5\nb,5,5,5\na,1,1,1\n", "n", {});
  CHECK_THROWS_WITH(look_at(named, {}, 2), Contains("n:3") && Contains("out of turn"));
}

TEST_CASE("the FARO file: 11 misses and 5 gross outliers, 24 um about the median", "[points]") {
  const auto path = real_data("faro_irb120_measured_base_3.txt");
  if (!path) return;
  const PointsFile file = read_points(*path, {});
  CHECK(file.format == "matrix");
  const PlaceLook nest = look_at(file).places.at(0);
  CHECK(nest.n == 984);
  CHECK(lines_of(nest.misses) ==
        std::vector<int>{116, 134, 135, 144, 179, 258, 337, 389, 850, 917, 977});
  CHECK(lines_of(nest.outliers) == std::vector<int>{22, 51, 136, 400, 721});
  for (const auto& outlier : nest.outliers) {
    CHECK((outlier.distance_mm > 243 && outlier.distance_mm < 404));
  }
  CHECK_THAT(nest.rms_mm, WithinAbs(0.024, 0.0005));
}

TEST_CASE("three reflectors, ten returns: RP (n = 10) of 13.0, 15.4 and 17.3 um", "[points]") {
  const auto path = real_data("ivr_pose1_3smr_x10.txt");
  if (!path) return;
  const PointsFile file = read_points(*path, {});
  CHECK(file.format == "sa-short");
  const PointsLook look = look_at(file);
  REQUIRE(look.places.size() == 3);
  const double expected_um[] = {13.0, 15.4, 17.3};
  for (std::size_t k = 0; k < 3; ++k) {
    CHECK(look.places[k].n == 10);
    CHECK(look.places[k].outliers.empty());
    CHECK_THAT(*look.places[k].RP_l_mm * 1000, WithinAbs(expected_um[k], 0.05));
  }
}

TEST_CASE("the SpatialAnalyzer export: header read, 397 points, dates left open", "[points]") {
  const auto path = real_data("sa_export_first400.txt");
  if (!path) return;
  const PointsFile file = read_points(*path, {});
  CHECK(file.format == "sa");
  CHECK(file.frame == "A::WORLD");
  CHECK((file.unit == "mm" && file.unit_stated));
  CHECK_THAT(file.program, Contains("2024.2.0923.4"));
  CHECK(file.rows.size() == 397);
  CHECK_FALSE(file.dates.order);  // 02/12/25 can be read two ways
  const PointsLook look = look_at(file);
  CHECK(look.by == PlaceBy::group);
  REQUIRE(look.places.size() == 1);
  CHECK(look.places[0].rms_mm < 0.005);
}
