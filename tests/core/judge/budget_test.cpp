#include "core/judge/budget.hpp"

#include <cmath>

#include "tests/support/catch.hpp"
#include "tests/support/workspace.hpp"

using namespace trammel;

namespace {

Campaign real_campaign() {
  Campaign c;
  c.machine = machine_of(paper_mechanism());
  c.tracker = TrackerSigma{0.010, 1e-4};
  for (const double temperature : {20.0, 23.0}) {
    Reading r;
    r.seq = static_cast<int>(c.readings.size()) + 1;
    r.measured = Pose{};
    r.conditions.temp_degc = temperature;
    c.readings.push_back(r);
  }
  return c;
}

double contribution(const std::vector<BudgetRow>& rows, const std::string& name) {
  for (const BudgetRow& row : rows) {
    if (row.name == name) return row.contribution_mm();
  }
  throw std::runtime_error("no row " + name);
}

}  // namespace

TEST_CASE(
    "each row is its half width over its divisor times its sensitivity, and U their root sum "
    "of squares",
    "[judge]") {
  const Campaign c = real_campaign();
  BudgetFacts facts;
  facts.instrument_mpe_mm = 0.012;
  facts.nests_mm = 0.003;
  facts.frame_u_mm = 0.004;
  facts.alpha_per_k = 23e-6;
  facts.temperature_spread_k = 2;
  facts.length_mm = 500;
  const auto rows = budget_of(c, facts, noise_level(c), 0.006);
  CHECK_THAT(contribution(rows, "instrument"), WithinAbs(0.012 / std::sqrt(3.0), 1e-15));
  CHECK_THAT(contribution(rows, "nests"), WithinAbs(0.003 / std::sqrt(3.0), 1e-15));
  CHECK(contribution(rows, "frame") == 0.004);
  CHECK_THAT(contribution(rows, "temperature"), WithinAbs(2 * 500 * 23e-6 / std::sqrt(3.0), 1e-15));
  CHECK(contribution(rows, "model") == 0.006);
  CHECK(contribution(rows, "repeats") == 0);
  double squares = 0;
  for (const BudgetRow& row : rows) squares += std::pow(row.contribution_mm(), 2);
  CHECK_THAT(combined_mm(rows), WithinAbs(std::sqrt(squares), 1e-15));
  CHECK_THAT(combined_mm(rows, false), WithinAbs(std::sqrt(squares - 0.006 * 0.006), 1e-15));
}

TEST_CASE("what is not stated is assumed and named so; of a simulated campaign nothing is",
          "[judge]") {
  Campaign c = real_campaign();
  for (const BudgetRow& row : budget_of(c, {}, noise_level(c), {})) {
    if (row.name == "repeats") continue;
    INFO(row.name);
    CHECK_THAT(row.source, Contains("assumed") || Contains("recorded"));
    CHECK(row.contribution_mm() > 0);
  }
  CHECK_THAT(contribution(budget_of(c, {}, noise_level(c), {}), "temperature"),
             WithinAbs(1.5 * 12e-6 * 733 / std::sqrt(3.0), 1e-12));
  c.simulated = true;
  CHECK(combined_mm(budget_of(c, {}, noise_level(c), {})) == 0);
}

TEST_CASE("instrument and frame cancel in an improvement, and all of it where after is predicted",
          "[judge]") {
  const Campaign c = real_campaign();
  BudgetFacts stable, nests;
  stable.nests_mm = stable.temperature_spread_k = 0;
  nests.nests_mm = 0.003;
  const auto cancelling = budget_of(c, stable, noise_level(c), 0.01);
  CHECK(combined_mm(cancelling) > 0.01);
  CHECK(relative_u(cancelling, 0.2, 0.02, false) == 0);
  const auto rows = budget_of(c, nests, noise_level(c), 0.01);
  CHECK(relative_u(rows, 0.2, 0.02, true) == 0);
  const double both = std::hypot(contribution(rows, "nests"), contribution(rows, "temperature"));
  CHECK_THAT(relative_u(rows, 0.2, 0.02, false),
             WithinAbs(both * std::hypot(1 / 0.2, 1 / 0.02), 1e-12));
}

TEST_CASE("what is assumed is of the instrument that is named, and nothing of an unknown one",
          "[judge]") {
  Campaign c = real_campaign();
  c.machine = starting_machine("X");  // a stroke of 300 mm
  const auto rows_of = [&](const char* name) {
    BudgetFacts facts;
    facts.instrument = name;
    return budget_of(c, facts, noise_level(c), {});
  };
  CHECK_THAT(contribution(rows_of("tracker"), "instrument"),
             WithinAbs(0.015 / std::sqrt(3.0), 1e-12));
  CHECK_THAT(contribution(rows_of("interferometer"), "instrument"),
             WithinAbs(0.5e-6 * 300 / std::sqrt(3.0), 1e-12));
  CHECK_THAT(contribution(rows_of("grid-encoder"), "instrument"),
             WithinAbs(0.002 / std::sqrt(3.0), 1e-12));
  const auto unknown = rows_of("unknown");
  CHECK(contribution(unknown, "instrument") == 0);
  CHECK_THAT(unknown.front().source, Contains("not known"));
  for (const char* name : {"interferometer", "grid-encoder", "unknown"}) {
    CHECK_THROWS(contribution(rows_of(name), "nests"));  // nothing is put back
    CHECK_THROWS(contribution(rows_of(name), "frame"));
  }
  CHECK(find_instrument("theodolite") == nullptr);
}
