#pragma once
// What a calibration is for: a target pose in, the displacements that reach it out.

#include <array>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "core/calibrate/joint_map.hpp"
#include "core/measure/reading.hpp"
#include "core/mechanism/forward.hpp"
#include "core/mechanism/inverse.hpp"
#include "core/mechanism/nominal_machine.hpp"
#include "core/model/robot_model.hpp"

namespace trammel {

/// No correction: the nominal inverse kinematics.
struct NominalCorrection {};

/// Inverse kinematics on the identified geometry (the paper's first method).
struct GeometryCorrection {
  Geometry geometry;
};

/// cmd = l_nominal(target) - e(cmd), e the map's joint errors where the nominal robot stands under
/// cmd (the paper's second and third methods, which look them up at the target: to first order). In
/// an epoch of `epochs` cmd counts from its joint zeros, and the target is in its frame.
struct MapCorrection {
  JointMap map;
  EpochShifts epochs = {};
};

/// The physical model: commands such that the model, moved as planned (direction, temperature,
/// time), reads the target.
struct ModelCorrection {
  RobotModel model;
};

/// The physical model first, then a map on the joint errors it leaves.
struct HybridCorrection {
  RobotModel model;
  JointMap left;
};

/// Values, so that a job can store them and a session can carry them.
using Correction = std::variant<NominalCorrection, GeometryCorrection, MapCorrection,
                                ModelCorrection, HybridCorrection>;

/// "nominal", "geometry", "map", "model", "hybrid": the word that stored corrections carry.
std::string kind_of(const Correction& correction);

/// The shifts of epochs that it holds; null where it has none.
EpochShifts* epochs_of(Correction& correction);

/// A move as it is planned: all a correction may use to choose the displacements.
struct Move {
  Pose target;
  Displacements from_mm = {};  // where the rails stand before it
  std::array<int, kChains> approach =
      {};  // +1, -1: the direction the rail will arrive in; 0: from from_mm
  int epoch = 1;
  std::optional<double> time_s = {};
  std::optional<double> temp_degc = {};
};

/// The move by which a reading was taken.
Move move_of(const Reading& reading);

/// Displacements to command so that the robot, as `correction` believes it to be, reaches the
/// target; or the first chain that cannot. theta_rad are the link angles of the geometry that was
/// solved. Proof: on the robot the correction believes in, the target is reached to 1e-9 mm
/// (correction_test.cpp).
InverseResult commanded(const Correction& correction, const NominalMachine& machine,
                        const Move& move);

/// Pose that the tracker would read under `conditions` if the robot were as `correction` believes.
ForwardResult believed(const Correction& correction, const NominalMachine& machine,
                       const Conditions& conditions);

/// What a model leaves of a reading, as joint errors: l(measured) - l(predicted), nominal inverse
/// kinematics. Samples for the map of a hybrid. Throws InputError as joint_error_mm.
std::vector<JointSample> samples_left(const RobotModel& model, std::span<const Reading> readings);

/// The reading as it would have been under the correction, from the reading as it was: the robot
/// keeps, as joint displacements, what the correction did not expect of it.
///   X' = forward(l(target) + l(X_measured) - l(X_expected)),   l, forward: nominal kinematics
///   X_expected = believed() under the conditions of the reading, its direction of approach too
/// The corrected command reads the target where the robot is as believed, so X' - target is the
/// reading's residual, moved to the target: exact where the correction is right, else to first
/// order in the change of the command times what is not known. Noise is kept as it was read. A
/// prediction, never a measurement: reports say so. In-sample for readings the correction was
/// fitted to. Nothing where the corrected robot cannot reach the target. Throws InputError where
/// the reading has no measured pose or leaves the nominal reach. Proof: the exact robot under the
/// corrected commands, backlash and short moves included (correction_test.cpp).
std::optional<Pose> predicted_after(const Correction& correction, const NominalMachine& machine,
                                    const Reading& reading);
/// Of many readings, with what they share done once; the same bits.
std::vector<std::optional<Pose>> predicted_after(const Correction& correction,
                                                 const NominalMachine& machine,
                                                 std::span<const Reading> readings);

}  // namespace trammel
