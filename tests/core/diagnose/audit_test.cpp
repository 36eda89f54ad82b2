#include "core/diagnose/audit.hpp"

#include <algorithm>

#include "tests/core/diagnose/space.hpp"
#include "tests/study/campaigns.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::tests;

namespace {

const AuditRow& row(const std::vector<AuditRow>& audit, const std::string& effect) {
  return *std::find_if(audit.begin(), audit.end(),
                       [&](const AuditRow& r) { return r.effect == effect; });
}

}  // namespace

TEST_CASE("a rich design shows every effect, and half of a lead error is eaten by the base",
          "[diagnose]") {
  const auto audit = audit_design(space_of(make_case({}, {}, 0, 1).campaign));
  for (const AuditRow& r : audit) {
    INFO(r.effect);
    CHECK(r.smallest_visible.has_value());
  }
  CHECK(row(audit, "backlash").surviving_share > 0.9);
  CHECK(row(audit, "lead_scale").surviving_share < 0.5);
  const auto& aliases = row(audit, "tracker_scale").aliases;
  CHECK(std::any_of(aliases.begin(), aliases.end(),
                    [](const Alias& a) { return a.effect == "lead_scale"; }));
}

TEST_CASE("with one direction and one temperature backlash and growth are told to be invisible",
          "[diagnose]") {
  HiddenCase c = make_case({.name = "paper"}, {}, 0, 2);
  for (Reading& r : c.campaign.readings) {
    r.conditions.from_mm = r.conditions.cmd_mm - Displacements::Constant(5);
    r.conditions.temp_degc = 20;
  }
  const auto audit = audit_design(space_of(c.campaign));
  CHECK(row(audit, "backlash").surviving_share == 0);
  CHECK_FALSE(row(audit, "backlash").missing.empty());
  CHECK(row(audit, "thermal_growth").surviving_share == 0);
}

TEST_CASE("the smallest visible size is what a hidden effect needs to be found", "[diagnose]") {
  const HiddenCase c = make_case({}, {}, 0, 3);
  const ResidualSpace space = space_of(c.campaign);
  const auto audit = audit_design(space);
  const AuditRow& lash = row(audit, "backlash");
  // a rail with that backlash gives the noncentrality it promises: |M e|^2 = z^2
  const Effect& effect = find_effect("backlash");
  double least = 1e300;
  for (int k = 0; k < 3; ++k) {
    const Eigen::VectorXd e =
        *lash.smallest_visible *
        whitened_signal(space, [&](const Reading&, const Moment& m) { return effect.basis(m, k); });
    least = std::min(least, space.project(e).norm());
  }
  CHECK_THAT(least, WithinRel(4.2 + 0.84, 1e-6));
}
