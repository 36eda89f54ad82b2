// Held-out figures of the interpolators on a real error map of a planar stage, by the code that
// ships.
//
//   planar_stage FILE    an Aerotech-style 2D calibration file: node 1, node 2, commanded mm, error
//   mm
//
// Every third node is a sample; the others inside the samples' hull are predicted. Exit 1 when IDW
// (p = 2, 8 neighbours) is not within 5 % of what this map is known to give.

#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "core/calibrate/gp.hpp"
#include "core/calibrate/idw.hpp"
#include "core/calibrate/rbf.hpp"

namespace {

using namespace trammel;

constexpr int kEvery = 3;
constexpr double kUmPerMm = 1000;
constexpr double kKnownUm[2] = {0.052, 0.074};
constexpr double kBilinearUm[2] = {0.051, 0.060};
constexpr double kWithin = 0.05;

struct Nodes {
  std::vector<JointSample> samples, held_out;
};

Nodes read(const char* path) {
  std::ifstream in(path);
  Nodes nodes;
  double hull_mm[2] = {-1e9, -1e9};
  std::vector<JointSample> others;
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '%') continue;
    std::istringstream cells(line);
    double i = 0, j = 0, c1 = 0, c2 = 0, e1 = 0, e2 = 0;
    if (!(cells >> i >> j >> c1 >> c2 >> e1 >> e2)) continue;
    const bool is_sample =
        (static_cast<int>(i) - 1) % kEvery == 0 && (static_cast<int>(j) - 1) % kEvery == 0;
    (is_sample ? nodes.samples : others).push_back({c1, c2, {e1, e2, 0}});
    if (is_sample) hull_mm[0] = std::max(hull_mm[0], c1), hull_mm[1] = std::max(hull_mm[1], c2);
  }
  for (const JointSample& s : others) {
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
  return 0;
}
