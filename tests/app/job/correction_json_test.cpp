#include "app/job/correction_json.hpp"

#include "core/statistics/random.hpp"
#include "tests/core/calibrate/campaigns.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::job;

namespace {

std::vector<JointSample> samples() {
  Random random(61);
  std::vector<JointSample> all;
  for (int k = 0; k < 30; ++k) {
    all.push_back({random.uniform(-100, 100),
                   random.uniform(-100, 100),
                   {random.normal(), random.normal(), random.normal()}});
  }
  return all;
}

RobotModel model(Random& random) {
  RobotModel m = nominal_model(paper_mechanism());
  set_geometry(m.machine, tests::random_geometry(random));
  m.epochs[2] = {.l_zero_mm = {0.1, 0.2, 0.3}, .frame = {0.01, 0.02, 1e-4}};
  m.effects = {{&find_effect("lead_scale"), Eigen::Vector3d(3e-3, 2e-3, 0)},
               {&find_effect("backlash"), Eigen::Vector3d(0.08, 0.07, 0.09)}};
  return m;
}

Correction there_and_back(const Correction& correction) {
  const Json wrapped = {{"correction", correction_json(correction)}, {"words", "other fields"}};
  return correction_of(wrapped.dump());
}

}  // namespace

TEST_CASE("every kind of correction comes back from JSON with the same bits", "[job]") {
  Random random(62);
  const std::vector<Correction> all = {
      NominalCorrection{},
      GeometryCorrection{tests::random_geometry(random)},
      MapCorrection{fit_idw(samples(), {.power = 2.5, .neighbours = 7})},
      MapCorrection{train_rbf(samples()).network},
      MapCorrection{fit_gp(samples())},
      MapCorrection{fit_idw(samples()),
                    {{2, EpochShift{Displacements(0.1, 0, -0.1), Pose{0.3, -0.2, 0.01}}}}},
      ModelCorrection{model(random)},
      HybridCorrection{model(random), fit_gp(samples())}};
  const Mechanism mechanism = paper_mechanism();
  for (const Correction& c : all) {
    const Correction back = there_and_back(c);
    CHECK(kind_of(back) == kind_of(c));
    CHECK(correction_json(back).dump() == correction_json(c).dump());
    for (int k = 0; k < 20; ++k) {
      const Move move{.target = tests::random_pose(random), .from_mm = {260, 260, 260}};
      CHECK(commanded(back, mechanism, move).l_mm == commanded(c, mechanism, move).l_mm);
    }
  }
}

TEST_CASE("a stored correction that is cut short or of unknown kind is refused by field", "[job]") {
  Json json = correction_json(MapCorrection{fit_idw(samples())});
  json["map"]["e2_mm"].erase(3);
  CHECK_THROWS_WITH(correction_of(Json{{"correction", json}}.dump()), Contains("e2_mm"));
  CHECK_THROWS_WITH(correction_of(R"({"correction": {"kind": "magic"}})"), Contains("kind"));
  CHECK_THROWS_WITH(correction_of(R"({"words": []})"), Contains("correction"));
}

TEST_CASE("a correction is read beside the points of 100,000 readings", "[job]") {
  Json result = {{"points", Json::array()},
                 {"correction", correction_json(GeometryCorrection{paper_mechanism().geometry})}};
  for (int k = 0; k < 7; ++k) result["points"].push_back(std::vector<double>(100'000, 0.5));
  CHECK(kind_of(correction_of(result.dump())) == "geometry");
}
