// Does the robot stand within U? Virtual robots of the demo's kind, where the truth is known.

#include "core/calibrate/uncertainty.hpp"

#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "core/calibrate/geometry_fit.hpp"
#include "core/calibrate/lsq.hpp"
#include "core/judge/deviation.hpp"
#include "core/model/effect.hpp"
#include "core/plan/grids.hpp"
#include "core/simulate/virtual_robot.hpp"
#include "core/units.hpp"
#include "tests/core/calibrate/campaigns.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::tests;

namespace {

const TrackerSigma kDemoSigma{0.010, rad_from_deg(0.055)};

/// Errors of the demo's kind and size (examples/paper/robot.json), drawn anew.
simulate::VirtualRobot demo_robot(std::uint64_t seed) {
  Random random = Random::stream(seed, "robot");
  simulate::Truth truth;
  Mechanism built = paper_mechanism();
  truth.nominal = machine_of(built);
  for (Chain& c : built.geometry.chains) {
    c.alpha_rad += rad_from_deg(0.010 * random.normal());
    c.beta_rad += rad_from_deg(0.008 * random.normal());
    c.r_mm += 0.03 * random.normal();
    c.S_mm += 0.03 * random.normal();
    c.R_mm += 0.05 * random.normal();
    c.h_mm += 0.03 * random.normal();
  }
  truth.actual = machine_of(built).chains;
  truth.zeroed = true;
  truth.phi_zero_rad = rad_from_deg(0.08 * random.normal());
  for (int i = 0; i < kChains; ++i) {
    truth.drive.lead_scale[i] = random.uniform(0.002, 0.005);
    truth.drive.backlash_mm[i] = random.uniform(0.07, 0.09);
    truth.drive.thermal_growth_per_k[i] = 1.2e-5;
    truth.drive.screw_sin_mm[i] = 0.005 * random.normal();
    truth.drive.screw_cos_mm[i] = 0.003 * random.normal();
  }
  truth.tracker = {.sigma_xy_mm = kDemoSigma.xy_mm, .sigma_phi_rad = kDemoSigma.phi_rad};
  truth.temperature = {.start_degc = 20, .rise_k = 3, .tau_s = 2400};
  truth.seed = seed;
  return simulate::VirtualRobot(truth);
}

/// Sent to `targets` one after another, from where it stood and when it is.
struct Walker {
  const simulate::VirtualRobot* robot;
  Displacements at_mm;
  double time_s = 0;
  int seq = 0;

  explicit Walker(const simulate::VirtualRobot& of) : robot(&of), at_mm(of.home_mm()) {}

  Reading read(const Correction& correction, const Pose& target, ReadingSet set) {
    const Mechanism nominal = mechanism_of(robot->truth().nominal);
    time_s += 20;
    Reading r{.seq = ++seq, .set = set, .target = target, .conditions = {}, .measured = {}};
    r.conditions = {.cmd_mm = at_mm,
                    .from_mm = at_mm,
                    .epoch = 1,
                    .time_s = time_s,
                    .temp_degc = robot->temperature_degc(time_s)};
    r.conditions.cmd_mm = commanded(correction, nominal, move_of(r)).l_mm;
    r.measured = robot->read(r.conditions, static_cast<std::uint64_t>(seq)).pose;
    at_mm = r.conditions.cmd_mm;
    return r;
  }
};

RobotModel with_effects(const Mechanism& mechanism) {
  RobotModel model = nominal_model(mechanism);
  for (const char* name : {"lead_scale", "backlash", "thermal_growth"}) {
    const Effect& effect = find_effect(name);
    const auto n = static_cast<Eigen::Index>(effect.parameters.size());
    model.effects.push_back({&effect, Eigen::VectorXd::Constant(n, 1e-12)});
  }
  return model;
}

std::map<std::string, Correction> corrections(const Mechanism& mechanism,
                                              const std::vector<Reading>& rows) {
  const auto samples = joint_samples(mechanism, rows);
  const auto model = [&](const RobotModel& start) {
    return fit_geometry(start, rows, kDemoSigma).model;
  };
  const RobotModel named = model(with_effects(mechanism));
  return {
      {"lsq", GeometryCorrection{identify_repeated(mechanism, rows, kDemoSigma, {}, 10).geometry}},
      {"geometry", ModelCorrection{model(nominal_model(mechanism))}},
      {"geometry, effects", ModelCorrection{named}},
      {"idw", MapCorrection{fit_idw(samples)}},
      {"rbf", MapCorrection{train_rbf(samples).network}},
      {"gp", MapCorrection{fit_gp(samples)}},
      {"hybrid", HybridCorrection{named, fit_gp(samples_left(named, rows))}}};
}

struct CoverageOfU {
  int within = 0, own_within = 0, all = 0;
  double mean_U_mm = 0, squares = 0;

  void add(double error_mm, double own_U_mm, double U_mm) {
    ++all;
    own_within += std::abs(error_mm) <= own_U_mm ? 1 : 0;
    within += std::abs(error_mm) <= U_mm ? 1 : 0;
    mean_U_mm += U_mm;
    squares += error_mm * error_mm;
  }
  [[nodiscard]] double share() const { return static_cast<double>(within) / all; }
};

/// Each robot is calibrated on the paper's 80 points, held-out readings of the `n_held_out` of the
/// paper's 48 that lie nearest to the middle correct U, and all 48 targets, within the hull of the
/// 80, are gone to under the correction.
std::map<std::string, CoverageOfU> study(int robots, std::uint64_t seed,
                                         std::size_t n_held_out = 48) {
  std::map<std::string, CoverageOfU> found;
  for (int k = 0; k < robots; ++k) {
    const simulate::VirtualRobot robot = demo_robot(seed + static_cast<std::uint64_t>(k));
    const Mechanism mechanism = mechanism_of(robot.truth().nominal);
    Walker baseline(robot);
    std::vector<Reading> rows, unseen;
    for (const Pose& p : paper_80()) {
      rows.push_back(baseline.read(NominalCorrection{}, p, ReadingSet::identify));
    }
    for (const Pose& p : paper_48()) {
      unseen.push_back(baseline.read(NominalCorrection{}, p, ReadingSet::validate));
    }
    for (const auto& [name, correction] : corrections(mechanism, rows)) {
      const auto own = own_uncertainty(correction, mechanism, rows, kDemoSigma);
      REQUIRE(own);
      std::vector<HeldOut> held_out;
      for (const Reading& r : unseen) {
        const Pose after = *predicted_after(correction, mechanism, r);
        held_out.push_back({&r, Pose::from(pose_difference(after, r.target))});
      }
      std::ranges::stable_sort(held_out, {}, [](const HeldOut& h) {
        return std::hypot(h.reading->target.x_mm, h.reading->target.y_mm);
      });
      held_out.resize(n_held_out);
      const PointUncertainty wider = calibrated(*own, held_out, kDemoSigma);
      Walker again = baseline;
      for (const Reading& before : unseen) {
        const Reading r = again.read(correction, before.target, ReadingSet::validate);
        const Pose truth = robot.true_pose(r.conditions).pose;
        const double own_U_mm = own->of(before).U_mm, U_mm = wider.of(before).U_mm;
        found[name].add(truth.x_mm - r.target.x_mm, own_U_mm, U_mm);
        found[name].add(truth.y_mm - r.target.y_mm, own_U_mm, U_mm);
      }
    }
  }
  return found;
}

std::string table(const std::map<std::string, CoverageOfU>& found) {
  std::string text;
  for (const auto& [name, c] : found) {
    char line[160];
    std::snprintf(line, sizeof line,
                  "%-18s %6d coordinates, %.1f %% within U (%.1f %% by itself), mean U %.4f mm, "
                  "twice the rms error %.4f mm\n",
                  name.c_str(), c.all, 100 * c.share(), 100.0 * c.own_within / c.all,
                  c.mean_U_mm / c.all, 2 * std::sqrt(c.squares / c.all));
    text += line;
  }
  return text;
}

}  // namespace

TEST_CASE("U covers 93 to 97 % of the coordinates of 200 robots, for each method",
          "[.coverage][calibrate]") {
  const auto found = study(200, 5000);
  std::printf("%s", table(found).c_str());
  for (const auto& [name, c] : found) {
    INFO(name << ": " << c.share());
    CHECK(c.share() >= 0.93);
    CHECK(c.share() <= 0.97);
  }
}

TEST_CASE("U covers where the held-out points lie near the middle of what was fitted",
          "[.coverage][calibrate]") {
  const auto found = study(200, 5000, 12);
  std::printf("%s", table(found).c_str());
  for (const auto& [name, c] : found) {
    INFO(name << ": " << c.share());
    CHECK(c.share() >= 0.90);
  }
}

TEST_CASE("a judged point is left out of what corrects its U, as if it were not there",
          "[calibrate]") {
  Random random(51);
  std::vector<Reading> readings(40);
  std::vector<HeldOut> all;
  for (std::size_t k = 0; k < readings.size(); ++k) {
    readings[k].seq = static_cast<int>(k) + 1;
    all.push_back({&readings[k],
                   Pose{0.05 * random.normal(), 0.05 * random.normal(), 0.001 * random.normal()}});
  }
  const PointUncertainty own{"test", [](const Reading& r) {
                               return Expanded{.U_mm = 0.05 + 0.001 * r.seq, .U_rad = 1e-4};
                             }};
  const auto same = [](const Expanded& a, const Expanded& b) {
    CHECK_THAT(a.U_mm, WithinAbs(b.U_mm, 1e-12));
    CHECK_THAT(a.U_rad, WithinAbs(b.U_rad, 1e-14));
  };
  for (const double sigma_mm : {0.001, 0.2}) {  // its shape is seen, or its size alone
    const TrackerSigma sigma{sigma_mm, 2e-4};
    for (std::size_t k = 0; k < all.size(); ++k) {
      std::vector<HeldOut> others = all;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
      const Reading& at = readings[k];
      same(calibrated(own, all, sigma).of(at), calibrated(own, others, sigma).of(at));
      same(held_out_uncertainty(all, "test", sigma).of(at),
           held_out_uncertainty(others, "test", sigma).of(at));
    }
  }
}

TEST_CASE("U covers what a robot's own errors leave, for each method, on a few robots",
          "[calibrate][release]") {
  // 6 robots, 576 coordinates a method, of which those of a robot go together: wide bounds.
  for (const auto& [name, c] : study(6, 1)) {
    INFO(name << ": " << c.share());
    CHECK(c.share() >= 0.88);
    CHECK(c.share() <= 0.995);
  }
  for (const auto& [name, c] : study(6, 1, 12)) {
    INFO(name << ", held out near the middle: " << c.share());
    CHECK(c.share() >= 0.85);
  }
}
