#include "core/judge/iso9283.hpp"

#include <map>

#include "core/error.hpp"
#include "core/statistics/random.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/csv.hpp"

using namespace trammel;

namespace {

std::map<std::string, double> golden_9283() {
  const auto t = tests::read_table("core/judge/golden/iso9283_figures.csv");
  std::map<std::string, double> figures;
  for (std::size_t k = 0; k < t.rows.size(); ++k)
    figures[t.text(k, "symbol")] = t.number(k, "value");
  return figures;
}

Reading visit(int seq, const Pose& target, int direction, const Eigen::Vector3d& off) {
  Reading r;
  r.seq = seq;
  r.target = target;
  r.conditions.cmd_mm = {250, 260, 270};
  r.conditions.from_mm = r.conditions.cmd_mm - 5.0 * direction * Displacements::Ones();
  r.conditions.time_s = 60.0 * seq;
  r.measured = Pose::from(target.vector() + off);
  return r;
}

std::vector<Reading> golden_visits() {
  const auto t = tests::read_table("core/judge/golden/iso9283_visits.csv");
  std::vector<Reading> readings;
  for (std::size_t k = 0; k < t.rows.size(); ++k) {
    readings.push_back(
        visit(static_cast<int>(k) + 1, {10, -20, 0.01}, static_cast<int>(t.number(k, "direction")),
              {t.number(k, "dx_mm"), t.number(k, "dy_mm"), t.number(k, "dphi_rad")}));
  }
  return readings;
}

/// `n` visits of each of `poses` places, noise 10 um and 0.004 deg.
std::vector<Reading> drawn(int poses, int n, Random& random) {
  std::vector<Reading> readings;
  for (int j = 0; j < n; ++j) {
    for (int p = 0; p < poses; ++p) {
      readings.push_back(visit(
          static_cast<int>(readings.size()) + 1, {10.0 * p, 0, 0}, 1,
          {0.01 * random.normal(), 0.01 * random.normal(), rad_from_deg(0.004) * random.normal()}));
    }
  }
  return readings;
}

const IsoSymbol& symbol(const Iso9283& of, const std::string& name) {
  for (const IsoSymbol& s : of.symbols) {
    if (s.name.starts_with(name)) return s;
  }
  throw std::runtime_error("no symbol " + name);
}

}  // namespace

TEST_CASE("ISO 9283 figures are those of a script written apart", "[assess]") {
  const auto golden = golden_9283();
  const auto readings = golden_visits();
  const auto poses = pose_visits(readings);
  REQUIRE(poses.size() == 2);
  for (const PoseVisits& p : poses) {
    const std::string side = p.direction[0] > 0 ? " up" : " down";
    INFO(side);
    const PoseAccuracy a = pose_accuracy(p.deviation);
    CHECK(a.n == 30);
    CHECK_THAT(a.AP_p_mm, WithinAbs(golden.at("AP_p" + side), 1e-13));
    CHECK_THAT(a.mean[0], WithinAbs(golden.at("AP_x" + side), 1e-13));
    CHECK_THAT(a.mean[1], WithinAbs(golden.at("AP_y" + side), 1e-13));
    CHECK_THAT(a.mean[2], WithinAbs(golden.at("AP_c" + side), 1e-13));
    CHECK_THAT(a.RP_l_mm, WithinAbs(golden.at("RP_l" + side), 1e-13));
    CHECK_THAT(a.RP_c_rad, WithinAbs(golden.at("RP_c" + side), 1e-13));
  }
  const Iso9283 all = iso9283(readings);
  CHECK_THAT(*symbol(all, "vAP_p").value, WithinAbs(golden.at("vAP_p"), 1e-13));
  CHECK_THAT(*symbol(all, "vAP_c").value, WithinAbs(golden.at("vAP_c"), 1e-13));
  CHECK_THAT(*symbol(all, "dAP_p").value,
             WithinAbs(std::max(golden.at("dAP_p up"), golden.at("dAP_p down")), 1e-13));
  CHECK_THAT(*symbol(all, "AP_p").value,
             WithinAbs(std::max(golden.at("AP_p up"), golden.at("AP_p down")), 1e-13));
}

TEST_CASE("one visit a pose gives a mean positional deviation and no ISO symbol", "[assess]") {
  Random random(93);
  const Iso9283 once = iso9283(drawn(80, 1, random));
  CHECK(once.most_n == 1);
  CHECK(once.mean_mm > 0);
  CHECK(once.symbols.size() == 10);
  for (const IsoSymbol& s : once.symbols) {
    INFO(s.name);
    CHECK_FALSE(s.value);
    CHECK_THAT(s.reason, Contains("n = 1"));
  }
}

TEST_CASE("few visits are in the name, thirty visits of five poses stand plainly", "[assess]") {
  Random random(94);
  const Iso9283 ten = iso9283(drawn(5, 10, random));
  CHECK(symbol(ten, "RP_l").name == "RP_l (n = 10)");
  CHECK(symbol(ten, "RP_l").reason == "the standard asks for n >= 30 visits, n = 10 here");
  const Iso9283 thirty = iso9283(drawn(5, 30, random));
  CHECK(symbol(thirty, "RP_l").name == "RP_l");
  CHECK(symbol(thirty, "RP_l").reason.empty());
  CHECK_FALSE(symbol(thirty, "vAP_p").value);
  CHECK_THAT(symbol(thirty, "vAP_p").reason, Contains("two directions"));
  const Iso9283 four = iso9283(drawn(5, 4, random));
  CHECK_FALSE(symbol(four, "AP_p").value);
  CHECK_THAT(symbol(four, "AP_p").reason, Contains("has n = 4"));
}

TEST_CASE("a perfect robot reads the floors that are stated beside AP and RP", "[assess]") {
  Random random(95);
  const TrackerSigma sigma{0.010, rad_from_deg(0.004)};
  const auto visits = drawn(1, 20000, random);
  const Iso9283 many = iso9283(visits, sigma);
  CHECK_THAT(*symbol(many, "RP_l").value, WithinRel(*symbol(many, "RP_l").floor, 0.02));
  CHECK_THAT(*symbol(many, "RP_c").value, WithinRel(*symbol(many, "RP_c").floor, 0.02));
  // AP_p of n visits is Rayleigh with sigma / sqrt(n): mean over many poses
  double sum = 0;
  for (int k = 0; k < 400; ++k) sum += *symbol(iso9283(drawn(1, 10, random)), "AP_p").value;
  CHECK_THAT(sum / 400,
             WithinRel(*symbol(iso9283(drawn(1, 10, random), sigma), "AP_p").floor, 4 * 0.52 / 20));
}

TEST_CASE("a growing offset shows as drift, and drift without times is refused", "[assess]") {
  std::vector<Reading> readings;
  for (int k = 0; k < 40; ++k) {
    readings.push_back(visit(k + 1, {0, 0, 0}, 1, {k < 20 ? 0.01 : 0.05, 0, 0}));
  }
  CHECK_THAT(*symbol(iso9283(readings), "dAP_p").value, WithinAbs(0.04, 1e-14));
  CHECK_THAT(symbol(iso9283(readings), "dAP_p").reason, Contains("the standard watches 8 h"));
  for (Reading& r : readings) r.conditions.time_s.reset();
  CHECK_FALSE(symbol(iso9283(readings), "dAP_p").value);
}

TEST_CASE("visits under another set-up are another pose, and nothing measured is refused",
          "[assess]") {
  Random random(96);
  auto readings = drawn(1, 10, random);
  for (std::size_t k = 5; k < 10; ++k) readings[k].conditions.epoch = 2;
  CHECK(iso9283(readings).n_poses == 2);
  CHECK(iso9283(readings).most_n == 5);
  for (Reading& r : readings) r.measured.reset();
  CHECK_THROWS_AS(iso9283(readings), InputError);
}

TEST_CASE("RP of one reflector in space is that of its distances from their mean", "[assess]") {
  // l = 3, 3, 3, 3, 0, 0: mean 2, S^2 = 12 / 5
  const std::vector<Eigen::Vector3d> points = {{13, 0, 5}, {7, 0, 5},  {10, 0, 8},
                                               {10, 0, 2}, {10, 0, 5}, {10, 0, 5}};
  CHECK_THAT(point_repeatability_mm(points), WithinRel(2 + 3 * std::sqrt(12.0 / 5), 1e-12));
}
