#pragma once
// One model asked about many readings: what belongs to the model alone is worked out once.

#include "core/mechanism/machine_solver.hpp"
#include "core/model/robot_model.hpp"

namespace trammel {

/// predict() and moment_of() of one model, which it must not outlive; the same bits. Proof:
/// robot_model_test.cpp.
class Predictor {
 public:
  explicit Predictor(const RobotModel& model);

  [[nodiscard]] Prediction predict(const Conditions& conditions) const;
  [[nodiscard]] Prediction moment_of(const Conditions& conditions) const;

 private:
  const RobotModel& model_;
  MachineSolver solver_;
  Displacements home_mm_;
};

}  // namespace trammel
