#pragma once
// The robot as we believe it to be: geometry, one shift an epoch, named effects. Predicts readings.

#include <map>
#include <memory>
#include <vector>

#include "core/measure/epochs.hpp"
#include "core/measure/reading.hpp"
#include "core/mechanism/machine_solver.hpp"
#include "core/model/effect.hpp"

namespace trammel {

/// An effect with a value for each of its parameters (0: carries nothing), in the parameters'
/// units.
struct ActiveEffect {
  const Effect* effect = nullptr;
  Eigen::VectorXd values;
};

class History;

struct RobotModel {
  Machine nominal;                   // home and leads are read from it
  Machine machine;                   // the same with identified parameters
  std::map<int, EpochShift> epochs;  // an epoch that is not listed has no shift
  std::vector<ActiveEffect> effects;
  std::shared_ptr<const History> history = {};  // of the campaign; none: see History

  /// Of a 3-PRR.
  [[nodiscard]] Mechanism mechanism() const { return mechanism_of(nominal); }
  [[nodiscard]] Geometry geometry() const { return geometry_of(machine); }
};

RobotModel nominal_model(const Machine& machine);
RobotModel nominal_model(const Mechanism& mechanism);

struct [[nodiscard]] Prediction {
  ForwardResult::Status status = ForwardResult::Status::not_converged;
  Pose pose;                              // ok only: what the tracker would read without noise
  Moment moment;                          // ok only: under what the effects acted
  ParameterColumns J_e;                   // ok only: at the pose
  const ChainColumns* columns = nullptr;  // of J_e
  [[nodiscard]] bool ok() const { return status == ForwardResult::Status::ok; }
};

/// Reading that the model expects under `conditions`.
///
///   X = forward(geometry with h + dh, cmd + l_zero(epoch) + dl),  reading = frame(epoch) * X + dX
/// where (dl, dh, dX) is the sum of the effects at the moment (effect.hpp), taken at the pose of
/// the geometry alone. An effect whose condition is not recorded (temperature, time) adds nothing.
/// Proof: each effect against a displacement worked out by hand (robot_model_test.cpp), and the
/// recovery of hidden effects that core/simulate wrote apart.
Prediction predict(const RobotModel& model, const Conditions& conditions);

/// Moment at the pose of the geometry alone; the effects of `model` do not enter.
Prediction moment_of(const RobotModel& model, const Conditions& conditions);

/// What the effect adds at a moment.
Deviation deviation_of(const ActiveEffect& active, const Moment& moment);

/// Its derivative by parameter `k`: the basis; of a shape a quotient of differences. Proof:
/// robot_model_test.cpp.
Deviation derivative_of(const RobotModel& model, const ActiveEffect& active,
                        const Conditions& conditions, const Moment& moment, int k);

/// How the reading follows a small `deviation` at a predicted moment, shape (3): mm, mm, rad.
Eigen::Vector3d response(const Prediction& at, const Deviation& deviation);

/// True when `moment` records what the effect needs (temperature, time).
bool recorded(const Effect& effect, const Moment& moment);

}  // namespace trammel
