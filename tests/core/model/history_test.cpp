// What is remembered of a path and of temperatures, worked out by hand.

#include "core/model/history.hpp"

#include <cmath>

#include "core/mechanism/machine_solver.hpp"
#include "core/model/effect.hpp"
#include "core/model/robot_model.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/workspace.hpp"

using namespace trammel;
using namespace trammel::tests;

namespace {

const Machine kMachine = machine_of(paper_mechanism());
const Displacements kHomeMm = drives_of(kMachine, kMachine.home);

/// The next row: all drives go from where they stand by `first_mm`, then by `then_mm`.
Reading moved(const std::vector<Reading>& path, double first_mm, double then_mm) {
  Reading r;
  r.seq = static_cast<int>(path.size()) + 1;
  const Displacements at = path.empty() ? kHomeMm : path.back().conditions.cmd_mm;
  r.conditions.from_mm = at + Displacements::Constant(first_mm);
  r.conditions.cmd_mm = r.conditions.from_mm + Displacements::Constant(then_mm);
  return r;
}

}  // namespace

TEST_CASE("a play is taken up over its radius, and by failed rows too", "[model]") {
  std::vector<Reading> path;
  path.push_back(moved(path, 0, 20));  // taken up in +
  path.push_back(moved(path, 0, -4));  // of 16 back to the other side
  path.push_back(moved(path, 0, -4));
  const History history(kMachine, path);
  CHECK_THAT(history.taken(path[0].conditions, 8, 8)[0], WithinAbs(1, 1e-12));
  CHECK_THAT(history.taken(path[1].conditions, 8, 8)[1], WithinAbs(0.5, 1e-12));
  CHECK_THAT(history.taken(path[2].conditions, 8, 8)[2], WithinAbs(0, 1e-12));
  CHECK_THAT(history.taken(path[2].conditions, 4, 8)[2], WithinAbs(-0.5, 1e-12));
  path.erase(path.begin() + 1);  // control: without the row between, another play
  CHECK(history.taken(path[1].conditions, 8, 8)[0] !=
        History(kMachine, {path[0]}).taken(path[1].conditions, 8, 8)[0]);
}

TEST_CASE("each epoch begins at home, and so does a reading off the path", "[model]") {
  std::vector<Reading> path;
  path.push_back(moved(path, 0, 20));
  path.push_back(moved(path, 0, -2));
  path.back().conditions.epoch = 2;
  const History history(kMachine, path);
  CHECK_THAT(history.taken(path[1].conditions, 32, 32)[0], WithinAbs(18.0 / 32, 1e-12));
  Reading off = moved({}, 0, 3);
  CHECK_THAT(history.taken(off.conditions, 4, 4)[0], WithinAbs(0.75, 1e-12));
}

TEST_CASE("the temperature behind a lag is the exact filter's, in any step", "[model]") {
  const double rise = 4, tau_s = 2000;
  for (const double lag_s : {70.0, 900.0, 3333.0, 20000.0}) {
    CAPTURE(lag_s);
    std::vector<Reading> path;
    for (int i = 0; i < 400; ++i) {
      Reading r = moved(path, 0, 1);
      r.conditions.time_s = 15.0 * i;
      r.conditions.temp_degc = 20 + rise * -std::expm1(-15.0 * i / tau_s);
      path.push_back(r);
    }
    const History history(kMachine, path);
    for (const std::size_t i : {std::size_t{10}, std::size_t{120}, std::size_t{399}}) {
      const double t = *path[i].conditions.time_s;
      // tau dF/dt = T - F with T = 20 + a (1 - exp(-t / b)), F(0) = 20
      const double F =
          20 + rise * (1 - (tau_s * std::exp(-t / tau_s) - lag_s * std::exp(-t / lag_s)) /
                               (tau_s - lag_s));
      CHECK_THAT(history.late_degc(path[i].conditions, lag_s), WithinAbs(F, 1e-3 * rise));
    }
    Conditions between = path[7].conditions;
    between.time_s = *between.time_s + 0.01;
    CHECK_THAT(history.late_degc(between, lag_s),
               WithinAbs(history.late_degc(path[7].conditions, lag_s), 1e-3));
  }
}

TEST_CASE("a delayed temperature is what the thermometer showed then", "[model]") {
  std::vector<Reading> path;
  for (const auto& [time_s, degc] : {std::pair{0.0, 20.0}, {100.0, 21.0}, {300.0, 25.0}}) {
    path.push_back(moved(path, 0, 1));
    path.back().conditions.time_s = time_s;
    path.back().conditions.temp_degc = degc;
  }
  const History history(kMachine, path);
  CHECK_THAT(history.delayed_degc(path[2].conditions, 0), WithinAbs(25, 1e-12));
  CHECK_THAT(history.delayed_degc(path[2].conditions, 100), WithinAbs(23, 1e-12));
  CHECK_THAT(history.delayed_degc(path[2].conditions, 250), WithinAbs(20.5, 1e-12));
  CHECK_THAT(history.delayed_degc(path[1].conditions, 900), WithinAbs(20, 1e-12));  // the first
}
