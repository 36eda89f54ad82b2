#include "app/device/simulated.hpp"

#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/mechanism/machine_solver.hpp"
#include "core/statistics/random.hpp"

namespace trammel::device {

namespace {

/// What the simulated devices share: the robot, and where its rails stand.
struct World {
  simulate::VirtualRobot robot;
  bool homed = false;
  Displacements l_mm = Displacements::Zero();
  Displacements from_mm = Displacements::Zero();  // where each rail's last move began
};

constexpr int kSamples = 4;  // polls on the way of a move

class SimulatedStage : public Stage {
 public:
  explicit SimulatedStage(std::shared_ptr<World> world) : world_(std::move(world)) {}

  [[nodiscard]] std::string describe() const override { return "virtual robot"; }
  [[nodiscard]] bool homed() const override { return world_->homed; }

  StageReport home() override {
    const std::scoped_lock lock(busy_);
    world_->l_mm = world_->from_mm = world_->robot.home_mm();
    world_->homed = true;
    return standing();
  }

  StageReport move(const Displacements& to_mm, const Watch& watch) override {
    if (!world_->homed) return {Status::fault, "the stage is not homed", {}};
    const Machine& nominal = world_->robot.truth().nominal;
    for (int i = 0; i < nominal.kind->n_chains; ++i) {
      const Limits& limits = nominal.drives[static_cast<std::size_t>(i)].limits;
      if (!(to_mm[i] >= limits.l_min_mm && to_mm[i] <= limits.l_max_mm)) {
        return {Status::limit, drive_name(nominal, i) + " would leave its stroke", {}};
      }
    }
    const Displacements begin = world_->l_mm;
    for (int i = 0; i < kChains; ++i) {
      if (std::abs(to_mm[i] - begin[i]) > kStandstillMm) world_->from_mm[i] = begin[i];
    }
    for (int sample = 0; sample <= kSamples; ++sample) {
      {
        const std::scoped_lock lock(busy_);
        world_->l_mm = sample < kSamples
                           ? begin + (to_mm - begin) * (static_cast<double>(sample) / kSamples)
                           : to_mm;
      }
      const Status seen = watch();
      if (seen != Status::ok) return {seen, "stopped on the way", world_->l_mm};
    }
    return standing();
  }

  StageReport stop() override {
    const std::scoped_lock lock(busy_);
    return standing();
  }

 private:
  [[nodiscard]] StageReport standing() const {
    return {Status::ok, "", world_->l_mm, world_->l_mm};
  }

  std::shared_ptr<World> world_;
  std::mutex busy_;  // where the rails are, which a stop beside a move asks
};

struct BaseNest {
  const char* name;
  double x_mm, y_mm;
};
constexpr std::array<BaseNest, 4> kBaseNests = {
    {{"B1", 350, 350}, {"B2", -350, 350}, {"B3", -350, -350}, {"B4", 350, -350}}};

class SimulatedTracker : public Tracker {
 public:
  explicit SimulatedTracker(std::shared_ptr<World> world) : world_(std::move(world)) {}

  [[nodiscard]] std::string describe() const override { return "virtual tracker"; }
  [[nodiscard]] Status beam() override { return Status::ok; }

  PoseReport measure(const Occasion& occasion) override {
    static_cast<void>(registered(occasion));
    const MachinePose seen = world_->robot.read(conditions(occasion), occasion.reading);
    if (!seen.ok()) return {Status::fault, "the virtual robot cannot stand there", {}, ""};
    return {Status::ok, "", seen.pose, ""};
  }

  [[nodiscard]] bool sees_base() const override { return true; }
  BaseReport measure_base(const Occasion& occasion) override {
    const std::vector<NestPoint>& before = registered(occasion);
    return {Status::ok, "",
            base_drift(before, base_seen(occasion), Eigen::Isometry3d::Identity(),
                       world_->robot.truth().tracker.sigma_xy_mm)};
  }

 private:
  [[nodiscard]] Conditions conditions(const Occasion& occasion) const {
    return {.cmd_mm = world_->l_mm,
            .from_mm = world_->from_mm,
            .epoch = occasion.epoch,
            .time_s = occasion.time_s,
            .temp_degc = {}};
  }

  /// An epoch's frame is registered with its first reading.
  const std::vector<NestPoint>& registered(const Occasion& occasion) {
    std::vector<NestPoint>& base = base_[occasion.epoch];
    if (base.empty()) base = base_seen(occasion);
    return base;
  }

  /// Noise of its own, numbered as the reading: no pose changes because the base is looked at.
  [[nodiscard]] std::vector<NestPoint> base_seen(const Occasion& occasion) const {
    const simulate::Truth& truth = world_->robot.truth();
    const double sigma_mm = truth.tracker.sigma_xy_mm;
    Random random = Random::stream(truth.seed, "base nests", occasion.reading);
    std::vector<NestPoint> points;
    for (const BaseNest& nest : kBaseNests) {
      const Pose at = world_->robot.seen({nest.x_mm, nest.y_mm, 0}, conditions(occasion));
      const double x = random.normal(), y = random.normal(), z = random.normal();
      points.push_back({nest.name, {at.x_mm + sigma_mm * x, at.y_mm + sigma_mm * y, sigma_mm * z}});
    }
    return points;
  }

  std::shared_ptr<World> world_;
  std::map<int, std::vector<NestPoint>> base_;  // by epoch, as they were when it was registered
};

class SimulatedThermometer : public Thermometer {
 public:
  explicit SimulatedThermometer(std::shared_ptr<World> world) : world_(std::move(world)) {}

  [[nodiscard]] std::string describe() const override { return "virtual air"; }
  TemperatureReport read(const Occasion& occasion) override {
    return {Status::ok, "", world_->robot.temperature_degc(occasion.time_s)};
  }

 private:
  std::shared_ptr<World> world_;
};

class SimulatedClock : public Clock {
 public:
  explicit SimulatedClock(std::shared_ptr<World> world) : world_(std::move(world)) {}

  void start(const Plan& plan, double start_s) override {
    times_s_ = schedule_s(world_->robot, plan, start_s);
  }
  double time_s(const PlannedPoint& point) override {
    return times_s_.at(static_cast<std::size_t>(point.seq) - 1);
  }
  [[nodiscard]] double end_s() const override { return times_s_.back(); }

 private:
  std::shared_ptr<World> world_;
  std::vector<double> times_s_;
};

}  // namespace

std::vector<double> schedule_s(const simulate::VirtualRobot& robot, const Plan& plan,
                               double start_s) {
  const MachineSolver nominal(robot.truth().nominal);
  const double stop_s = robot.truth().motion.settle_s;
  std::vector<double> times_s;
  Displacements at = robot.home_mm(), from = at;
  double now_s = start_s;
  for (const PlannedPoint& point : plan.points) {
    const InverseResult target = nominal.drives(point.target);
    if (!target.ok()) {
      throw InputError(
          {.what = "a target is out of reach of chain " + std::to_string(target.chain + 1),
           .where = {.point = std::to_string(point.seq)}});
    }
    const PlannedMove move = planned_move(plan, point, target.l_mm, at, from);
    if (move.pre_position) now_s += robot.travel_s(at, move.pre_mm) + stop_s;
    now_s += robot.travel_s(move.pre_mm, target.l_mm) + stop_s + robot.truth().motion.measure_s;
    times_s.push_back(now_s);
    at = target.l_mm;
    from = move.from_mm;
  }
  return times_s;
}

Devices simulated(const simulate::VirtualRobot& robot, std::string identity) {
  const auto world = std::make_shared<World>(World{robot, false, {}, {}});
  world->l_mm = world->from_mm = robot.home_mm();
  Devices devices;
  devices.simulated = true;
  devices.virtual_time = true;
  devices.identity = std::move(identity);
  devices.machine = robot.truth().nominal;
  devices.motion.speed_mm_s = robot.truth().motion.speed_mm_s;
  const simulate::TrackerTruth& t = robot.truth().tracker;
  if (t.sigma_xy_mm > 0) devices.sigma = TrackerSigma{t.sigma_xy_mm, t.sigma_phi_rad};
  devices.stage = std::make_unique<SimulatedStage>(world);
  devices.tracker = std::make_unique<SimulatedTracker>(world);
  devices.thermometer = std::make_unique<SimulatedThermometer>(world);
  devices.clock = std::make_unique<SimulatedClock>(world);
  return devices;
}

}  // namespace trammel::device
