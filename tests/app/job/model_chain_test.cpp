// The chain nominal -> geometry -> +effect, as stored: every step is a model of its own.

#include "app/job/model_chain.hpp"

#include "tests/study/campaigns.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::job;
using namespace trammel::tests;

namespace {

const Json* fitted(const Json& step, const char* list, const std::string& name) {
  for (const Json& p : step[list]) {
    if (p["name"] == name) return &p;
  }
  return nullptr;
}

}  // namespace

TEST_CASE("each step of the chain has its own values and standard deviations, counted from nominal",
          "[job]") {
  const HiddenCase c =
      make_case({.epochs = 2}, {&family("backlash"), &family("lead_curvature")}, 26, 5);
  const Diagnosis d = diagnose(c.campaign, {.replicates = 500});
  REQUIRE(d.gap.size() == 4);
  const Json chain = model_chain_json(d);
  REQUIRE(chain.size() == 4);
  CHECK(chain[0]["geometry"].empty());
  const GeometryVector nominal = to_vector(mechanism_of(c.campaign.machine).geometry);
  for (std::size_t k = 1; k < chain.size(); ++k) {
    const Json& step = chain[k];
    CAPTURE(step["name"].get<std::string>());
    CHECK(step["geometry"].size() == 21 + 6);  // and the second epoch's own
    int with_std = 0;
    for (const Json& p : step["geometry"]) with_std += p.contains("std") ? 1 : 0;
    CHECK(with_std >= 6);
    // every change is the step's own geometry less the nominal one
    const GeometryVector values = to_vector(d.gap[k].robot.geometry());
    for (int j = 0; j < kGeometryParameters; ++j) {
      const GeometryParameter& about = geometry_parameters()[static_cast<std::size_t>(j)];
      const double unit = about.is_angle ? 180 / 3.14159265358979323846 : 1;
      const Json* p = fitted(step, "geometry", about.name);
      REQUIRE(p != nullptr);
      CHECK_THAT((*p)["change"].get<double>(), WithinAbs(unit * (values[j] - nominal[j]), 1e-12));
    }
    for (const Json& p : step["effects"]) CHECK(p["std"].get<double>() > 0);
    CHECK(step.contains("identify_rms_mm"));
    CHECK(step.contains("validate_rms_mm"));
  }
  // The first effect alone is fitted to other values than beside the second.
  CHECK(chain[1]["effects"].empty());
  const Json& first = chain[2]["effects"][0];
  const Json* later = fitted(chain[3], "effects", first["name"]);
  REQUIRE(later != nullptr);
  CHECK(first["value"] != (*later)["value"]);
  CHECK(chain[3]["effects"].size() > chain[2]["effects"].size());
}
