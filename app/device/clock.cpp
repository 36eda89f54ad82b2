#include "app/device/clock.hpp"

#include <chrono>

#include "app/device/galil_axis.hpp"
#include "core/error.hpp"
#include "core/mechanism/machine_solver.hpp"

namespace trammel::device {

namespace {

using Steady = std::chrono::steady_clock;

class RealClock : public Clock {
 public:
  explicit RealClock(const Pace& pace) : pace_(pace) {}

  void start(const Plan& plan, double start_s) override {
    begun_ = Steady::now();
    start_s_ = start_s;
    end_s_ = start_s + duration_s(plan);
  }
  double time_s(const PlannedPoint&) override {
    return start_s_ + std::chrono::duration<double>(Steady::now() - begun_).count();
  }
  [[nodiscard]] double end_s() const override { return end_s_; }

 private:
  [[nodiscard]] double way_s(const Displacements& from_mm, const Displacements& to_mm) const {
    const double longest_mm = (to_mm - from_mm).cwiseAbs().maxCoeff();
    return travel_time_s(longest_mm, pace_.speed_mm_s, pace_.acceleration_mm_s2) + pace_.settle_s;
  }

  [[nodiscard]] double duration_s(const Plan& plan) const {
    const MachineSolver nominal(pace_.machine);
    Displacements at = drives_of(pace_.machine, pace_.machine.home), from = at;
    double seconds = 0;
    for (const PlannedPoint& point : plan.points) {
      const InverseResult target = nominal.drives(point.target);
      if (!target.ok()) {
        throw InputError(
            {.what = "a target is out of reach of chain " + std::to_string(target.chain + 1),
             .where = {.point = std::to_string(point.seq)}});
      }
      const PlannedMove move = planned_move(plan, point, target.l_mm, at, from);
      if (move.pre_position) seconds += way_s(at, move.pre_mm);
      seconds += way_s(move.pre_mm, target.l_mm) + pace_.measure_s;
      at = target.l_mm;
      from = move.from_mm;
    }
    return seconds;
  }

  Pace pace_;
  Steady::time_point begun_ = Steady::now();
  double start_s_ = 0;
  double end_s_ = 0;
};

}  // namespace

std::unique_ptr<Clock> real_clock(const Pace& pace) { return std::make_unique<RealClock>(pace); }

}  // namespace trammel::device
