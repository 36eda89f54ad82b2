// Held-out figures of the interpolators and of the named effects on a real error map of a planar
// stage, by the code that ships.
//
//   planar_stage FILE    an Aerotech-style 2D calibration file: node 1, node 2, commanded mm, error
//   mm
//
// Every third node is a sample; the others inside the samples' hull are predicted by the
// interpolators, all others by the models of the stage. Exit 1 when IDW (p = 2, 8 neighbours) or a
// model is not within 5 % of what this map is known to give.

#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "core/calibrate/geometry_fit.hpp"
#include "core/calibrate/gp.hpp"
#include "core/calibrate/idw.hpp"
#include "core/calibrate/rbf.hpp"
#include "core/units.hpp"

namespace {

using namespace trammel;

constexpr int kEvery = 3;
constexpr double kUmPerMm = 1000;
constexpr double kKnownUm[2] = {0.052, 0.074};
constexpr double kBilinearUm[2] = {0.051, 0.060};
constexpr double kWithin = 0.05;

struct Nodes {
  std::vector<JointSample> samples, held_out, others;
};

Nodes read(const char* path) {
  std::ifstream in(path);
  Nodes nodes;
  double hull_mm[2] = {-1e9, -1e9};
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '%') continue;
    std::istringstream cells(line);
    double i = 0, j = 0, c1 = 0, c2 = 0, e1 = 0, e2 = 0;
    if (!(cells >> i >> j >> c1 >> c2 >> e1 >> e2)) continue;
    const bool is_sample =
        (static_cast<int>(i) - 1) % kEvery == 0 && (static_cast<int>(j) - 1) % kEvery == 0;
    (is_sample ? nodes.samples : nodes.others).push_back({c1, c2, {e1, e2, 0}});
    if (is_sample) hull_mm[0] = std::max(hull_mm[0], c1), hull_mm[1] = std::max(hull_mm[1], c2);
  }
  for (const JointSample& s : nodes.others) {
    if (s.x_mm <= hull_mm[0] && s.y_mm <= hull_mm[1]) nodes.held_out.push_back(s);
  }
  return nodes;
}

/// Root mean square of both axes, um.
template <class Map>
Eigen::Vector2d held_out_rms_um(const Map& map, const std::vector<JointSample>& held_out) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const JointSample& s : held_out) {
    sum += (predict(map, Place{s.x_mm, s.y_mm}) - s.error_mm).template head<2>().cwiseAbs2();
  }
  return kUmPerMm * (sum / static_cast<double>(held_out.size())).cwiseSqrt();
}

/// Axis 1 of the file is Y, axis 2 is X.
std::vector<Reading> readings_of(const std::vector<JointSample>& nodes) {
  std::vector<Reading> readings;
  for (const JointSample& s : nodes) {
    Reading r;
    r.seq = static_cast<int>(readings.size()) + 1;
    r.target = {s.y_mm, s.x_mm, 0};
    r.conditions.cmd_mm = r.conditions.from_mm = {s.y_mm, s.x_mm, 0};
    r.measured = {s.y_mm + s.error_mm[1], s.x_mm + s.error_mm[0], 0};
    readings.push_back(r);
  }
  return readings;
}

struct ModelFigures {
  const char* adds;
  std::vector<const char*> effects;
  double known_um[2];  // X, Y
};
const ModelFigures kModels[] = {
    {"geometry", {}, {0.225, 0.191}},
    {"+ lead_scale", {"lead_scale"}, {0.202, 0.097}},
    {"+ guide_bow, lead_curvature", {"guide_bow", "lead_curvature"}, {0.173, 0.097}},
    {"+ guide_yaw", {"guide_yaw"}, {0.143, 0.089}}};

/// Each model refitted to the samples, with the effects of those before it. False where one is off.
bool models_hold(const Nodes& nodes) {
  Machine stage = starting_machine("XY");
  for (Drive& drive : stage.drives) drive.limits = {-300, 300};
  const std::vector<Reading> fitted = readings_of(nodes.samples);
  const std::vector<Reading> unseen = readings_of(nodes.others);
  const TrackerSigma sigma{0.0001, 1};
  RobotModel model = nominal_model(stage);
  bool hold = true;
  for (const ModelFigures& m : kModels) {
    for (const char* name : m.effects) {
      const Effect& effect = find_effect(name);
      Eigen::VectorXd values = Eigen::VectorXd::Zero(kChains);
      for (int k = 0; k < 2; ++k) {
        values[k] = 1e-6 * effect.parameters[static_cast<std::size_t>(k)].usual_max;
      }
      model.effects.push_back({&effect, values});
    }
    const GeometryFit fit = fit_geometry(model, fitted, sigma);
    model.effects = fit.model.effects;
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const Reading& r : unseen) {
      const Prediction at = predict(fit.model, r.conditions);
      sum += (r.measured->vector() - at.pose.vector()).head<2>().cwiseAbs2();
    }
    const Eigen::Vector2d rms = kUmPerMm * (sum / static_cast<double>(unseen.size())).cwiseSqrt();
    std::printf("  %-28s%.3f / %.3f   (known: %.3f / %.3f)\n", m.adds, rms[0], rms[1],
                m.known_um[0], m.known_um[1]);
    for (int axis = 0; axis < 2; ++axis) {
      hold = hold && std::abs(rms[axis] / m.known_um[axis] - 1) <= kWithin;
    }
    if (!m.effects.empty()) continue;
    // the file does not say whether its errors are to be added or taken off: the sign is open
    const double square_urad =
        1e6 * (fit.model.machine.chains[0][1] - fit.model.machine.chains[1][1] - kPi / 2);
    std::printf("  squareness                  %+.1f urad   (known: 9.8)\n", square_urad);
    hold = hold && std::abs(std::abs(square_urad) / 9.8 - 1) <= kWithin;
  }
  return hold;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: planar_stage FILE\n");
    return 2;
  }
  const Nodes nodes = read(argv[1]);
  if (nodes.samples.size() < 16 || nodes.held_out.empty()) {
    std::fprintf(stderr, "%s is not a map of a planar stage\n", argv[1]);
    return 4;
  }
  const auto idw =
      held_out_rms_um(fit_idw(nodes.samples, {.power = 2, .neighbours = 8}), nodes.held_out);
  const auto all = held_out_rms_um(fit_idw(nodes.samples), nodes.held_out);
  const RbfTraining training = train_rbf(nodes.samples, {.neurons = 144});
  const auto rbf = held_out_rms_um(training.network, nodes.held_out);
  std::printf("%zu samples, %zu held out; root mean square, um, axis 1 / axis 2\n",
              nodes.samples.size(), nodes.held_out.size());
  std::printf("  idw p = 2, 8 neighbours   %.3f / %.3f   (known: %.3f / %.3f)\n", idw[0], idw[1],
              kKnownUm[0], kKnownUm[1]);
  std::printf("  idw p = 2, all            %.3f / %.3f\n", all[0], all[1]);
  std::printf("  rbf 144 neurons, %3.0f mm   %.3f / %.3f\n", training.sigma_mm, rbf[0], rbf[1]);
  const auto gp = held_out_rms_um(fit_gp(nodes.samples), nodes.held_out);
  std::printf("  gp                        %.3f / %.3f\n", gp[0], gp[1]);
  std::printf("  bilinear, for comparison              (known: %.3f / %.3f)\n", kBilinearUm[0],
              kBilinearUm[1]);
  for (int axis = 0; axis < 2; ++axis) {
    if (std::abs(idw[axis] / kKnownUm[axis] - 1) > kWithin) return 1;
  }
  std::printf("the stage as a machine; %zu nodes that no fit has seen, um, X / Y\n",
              nodes.others.size());
  return models_hold(nodes) ? 0 : 1;
}
