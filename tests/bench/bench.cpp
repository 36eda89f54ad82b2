// trammel_bench ROW FOLDER: one row of scripts/bench. Inputs are made by `inputs`, or by the peers.

#include <cstdio>
#include <map>

#include "core/calibrate/geometry_fit.hpp"
#include "core/calibrate/idw.hpp"
#include "core/calibrate/rbf.hpp"
#include "core/linear/least_squares.hpp"
#include "core/mechanism/displacements.hpp"
#include "core/mechanism/inverse.hpp"
#include "core/plan/grids.hpp"
#include "core/statistics/random.hpp"
#include "core/units.hpp"
#include "store/campaign.hpp"
#include "store/open.hpp"
#include "store/transaction.hpp"
#include "tests/bench/bench.hpp"
#include "tests/support/workspace.hpp"

namespace trammel::bench {

namespace {

using Path = std::filesystem::path;

constexpr TrackerSigma kSigma{0.010, rad_from_deg(0.004)};
constexpr double kSpreadMm = 60;  // of the network whose training is timed

/// 80 readings of a robot with machining errors, at three orientations: rank 18.
std::vector<Reading> readings(const Path& folder) {
  const auto values = read(folder / "readings.f64");  // rows: cmd 1-3, measured x y phi
  std::vector<Reading> all;
  for (std::size_t k = 0; k + 6 <= values.size(); k += 6) {
    Reading r;
    r.seq = static_cast<int>(k / 6) + 1;
    r.conditions.cmd_mm = r.conditions.from_mm = {values[k], values[k + 1], values[k + 2]};
    r.measured = Pose{values[k + 3], values[k + 4], values[k + 5]};
    all.push_back(r);
  }
  return all;
}

/// The paper's 80 points at three orientations, read on a robot with machining errors.
std::vector<Reading> measured(Random& random) {
  const Geometry truth = tests::random_geometry(random);
  const Mechanism nominal = paper_mechanism();
  std::vector<Reading> all;
  for (Pose target : paper_80()) {
    target.phi_rad = rad_from_deg(4.0 * (static_cast<int>(all.size()) % 3 - 1));
    const Displacements l = inverse(nominal.geometry, target).l_mm;
    const Pose at = forward(truth, l).pose;
    Reading r;
    r.seq = static_cast<int>(all.size()) + 1;
    r.target = target;
    r.conditions.cmd_mm = r.conditions.from_mm = l;
    r.measured =
        Pose{at.x_mm + kSigma.xy_mm * random.normal(), at.y_mm + kSigma.xy_mm * random.normal(),
             at.phi_rad + kSigma.phi_rad * random.normal()};
    all.push_back(r);
  }
  return all;
}

void make_inputs(const Path& folder) {
  Random random(2024);
  std::vector<double> rows;
  for (const Reading& r : measured(random)) {
    for (const double v : r.conditions.cmd_mm) rows.push_back(v);
    for (const double v : r.measured->vector()) rows.push_back(v);
  }
  write(folder / "readings.f64", rows.data(), rows.size());
}

/// archive.db: campaigns of those points, each of another robot. Prints: seconds of the imports.
template <int campaigns>
void make_archive(const Path& folder) {
  Random random(2025);
  double seconds = 0;
  for (const char* end : {"", "-wal", "-shm"}) {
    std::filesystem::remove((folder / "archive.db").string() + end);
  }
  store::Connection db = store::open(folder / "archive.db", store::Access::create);
  store::Transaction all(db);
  for (int k = 1; k <= campaigns; ++k) {
    Campaign c;
    c.name = "campaign " + std::to_string(k);
    c.simulated = true;
    c.machine = machine_of(paper_mechanism());
    c.tracker = kSigma;
    c.readings = measured(random);
    seconds += best(
        1, [&] { store::import_campaign(db, c); }, clock_s);
  }
  all.commit();
  std::printf("%.9g\n", seconds);
}

double say(double seconds) {
  std::printf("%.9g\n", seconds);
  return seconds;
}

void nonlinear(const Path& folder) {
  const auto all = readings(folder);
  const RobotModel start = nominal_model(paper_mechanism());
  GeometryFit fit;
  say(best(30, [&] { fit = fit_geometry(start, all, kSigma); }));
  const double out[] = {fit.chi2, static_cast<double>(fit.identified.rank),
                        static_cast<double>(fit.iterations)};
  write(folder / "nonlinear.out", out, 3);
}

void linear(const Path& folder) {
  const auto values = read(folder / "linear.f64");  // A row by row, then b
  const Eigen::MatrixXd A =
      Eigen::Map<const Eigen::Matrix<double, 240, 18, Eigen::RowMajor>>(values.data());
  const Eigen::VectorXd b = Eigen::Map<const Eigen::VectorXd>(values.data() + A.size(), 240);
  Eigen::VectorXd z;
  say(best(300, [&] { z = basic_solution(A, b, 18); }));
  write(folder / "linear.out", z.data(), 18);
}

std::vector<JointSample> samples(const Path& folder) {
  const auto values = read(folder / "samples.f64");  // rows: x y e1 e2 e3
  std::vector<JointSample> all;
  for (std::size_t k = 0; k + 5 <= values.size(); k += 5) {
    JointSample s;
    s.x_mm = values[k];
    s.y_mm = values[k + 1];
    s.error_mm = {values[k + 2], values[k + 3], values[k + 4]};
    all.push_back(s);
  }
  return all;
}

std::vector<Place> queries(const Path& folder) {
  const auto values = read(folder / "queries.f64");
  std::vector<Place> all;
  for (std::size_t k = 0; k + 2 <= values.size(); k += 2) all.push_back({values[k], values[k + 1]});
  return all;
}

template <class Map>
void predict_all(const Path& folder, const Map& map, const char* name) {
  const auto at = queries(folder);
  std::vector<Eigen::Vector3d> out(at.size());
  say(best(3, [&] { predict(map, at, out); }));
  write(folder / name, out.front().data(), 3 * out.size());
}

void idw(const Path& folder) { predict_all(folder, fit_idw(samples(folder)), "idw.out"); }

void rbf(const Path& folder) {
  const auto values = read(folder / "network.f64");  // rows: cx cy w1 w2 w3, then sigma, bias
  const Eigen::Index m = 50;
  const auto rows = Eigen::Map<const Eigen::Matrix<double, 50, 5, Eigen::RowMajor>>(values.data());
  const Eigen::Vector3d bias = Eigen::Map<const Eigen::Vector3d>(values.data() + 5 * m + 1);
  const RbfNetwork network{rows.col(0), rows.col(1),
                           Eigen::ArrayXd::Constant(m, values[static_cast<std::size_t>(5 * m)]),
                           rows.rightCols<3>(), bias};
  predict_all(folder, network, "rbf.out");
}

void train(const Path& folder) {
  const auto all = samples(folder);
  RbfTraining training;
  say(best(20, [&] { training = train_rbf(all, {.sigma_mm = kSpreadMm}); }));
  const auto at = queries(folder);
  std::vector<Eigen::Vector3d> out(1000);
  predict(training.network, std::span(at).first(out.size()), out);
  write(folder / "train.out", out.front().data(), 3 * out.size());
}

std::vector<Pose> poses(const Path& folder) {
  const auto values = read(folder / "poses.f64");
  std::vector<Pose> all;
  for (std::size_t k = 0; k + 3 <= values.size(); k += 3) {
    all.push_back({values[k], values[k + 1], values[k + 2]});
  }
  return all;
}

void inverse_batch(const Path& folder) {
  const auto at = poses(folder);
  const RailFrames frames = rail_frames(paper_mechanism().geometry);
  std::vector<Displacements> l(at.size());
  std::size_t reached = 0;
  say(best(5, [&] { reached = inverse_displacements(frames, at, l); }));
  if (reached != at.size()) throw std::runtime_error("a pose of the bench is out of reach");
  write(folder / "inverse.out", l.front().data(), 3 * l.size());
}

void inverse_single(const Path& folder) {
  const auto at = poses(folder);
  const RailFrames frames = rail_frames(paper_mechanism().geometry);
  double sum = 0;
  const double seconds = best(3, [&] {
    for (const Pose& pose : at) sum += (*inverse_displacements(frames, pose))[0];
  });
  std::printf("%.9g\n", seconds / static_cast<double>(at.size()));
  write(folder / "single.out", &sum, 1);
}

}  // namespace

int run(const std::string& row, const Path& folder) {
  const std::map<std::string, void (*)(const Path&)> rows = {
      {"inputs", make_inputs},
      {"archive_100", make_archive<100>},
      {"archive", make_archive<1000>},
      {"archive_10000", make_archive<10'000>},
      {"nonlinear", nonlinear},
      {"linear", linear},
      {"idw", idw},
      {"rbf", rbf},
      {"train", train},
      {"inverse_batch", inverse_batch},
      {"inverse_single", inverse_single},
      {"record", record},
      {"import", import_readings}};
  const auto found = rows.find(row);
  if (found == rows.end()) return 2;
  found->second(folder);
  return 0;
}

}  // namespace trammel::bench

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  try {
    return trammel::bench::run(argv[1], argv[2]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "trammel_bench: %s\n", error.what());
    return 1;
  }
}
