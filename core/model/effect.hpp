#pragma once
// Physical effects: what is added to the geometry. Each is data plus one function; all are linear
// in their parameters, so that formula and derivative are the same function.

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/mechanism/machine.hpp"
#include "core/mechanism/pose.hpp"

namespace trammel {

struct Conditions;
class History;

/// Under what an effect acts at one reading.
struct Moment {
  Displacements l_mm = Displacements::Zero();  // commanded
  Displacements s_mm = Displacements::Zero();  // l - l(home)
  Displacements guide_mm =
      Displacements::Zero();  // along the guide from home: s of a PRR, of a PPR along gamma
  Displacements lever_mm =
      Displacements::Zero();  // along a passive guide, from its drive to the platform's joint
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // sign(cmd - from) per rail: -1, 0, 1
  Displacements travel_mm = Displacements::Zero();      // cmd - from
  std::optional<double> temp_degc = {};
  std::optional<double> time_h = {};              // since the campaign's start
  Pose pose = {};                                 // where the geometry alone puts the platform
  Eigen::Matrix3d J_V = Eigen::Matrix3d::Zero();  // dX/dl at that pose
  Eigen::Vector3d theta_rad = Eigen::Vector3d::Zero();  // link or cylinder angles at that pose
  Eigen::Vector3d lead_mm = Eigen::Vector3d::Zero();    // of each drive's screw
  bool turns_with_axes = false;  // phi is no coordinate: a parasitic angle of the axes
  // What is remembered there of the campaign (history.hpp), at the model's shape of each memory:
  double fading_mm = 0;                         // the length over which that of a move fades
  Displacements taken = Displacements::Zero();  // of the play, -1 to 1
  std::optional<double> late_degc = {};         // the temperature that the rails have reached
};

/// What one effect changes at one reading: displacements, the offsets across guides (a PRR's rail,
/// a PPR's passive guide), and the reading itself. What a machine has not follows nothing.
struct Deviation {
  Eigen::Vector3d dl_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d dh_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d dX = Eigen::Vector3d::Zero();  // x_mm, y_mm, phi_rad

  Deviation& operator+=(const Deviation& other);
};
Deviation operator*(double factor, const Deviation& deviation);

/// A condition a campaign must vary for an effect to be visible at all.
enum class Need { travel, direction, temperature, time, orientation };
std::string to_string(Need need);

/// On what a parameter acts: it exists on the machines that have it.
enum class On {
  drive,       // every machine
  guide,       // a rail of a PRR, a passive guide of a PPR along which the platform travels
  passive,     // a passive guide of a PPR along which the platform travels
  platform,    // a platform with joints: on a point the same is geometry
  reading,     // every machine
  coordinate,  // x, y, phi in turn: where it is measured
  shape,       // nothing: how far an effect remembers (length, time). Not linear, by no basis
  choice,      // a shape that has a few values only, and is chosen, not fitted
};

struct EffectParameter {
  std::string name;  // as in the report: "k_1"
  std::string unit;
  int rail = -1;         // 0, 1, 2; -1 when it belongs to no rail
  double usual_max = 0;  // beyond it a fitted value is unusual (weak: flagged, not refused)
  double usual_min =
      -std::numeric_limits<double>::infinity();  // replaced by -usual_max when not stated
  bool joined = false;  // enters and leaves a model with the parameter before it
  On on = On::drive;
  [[nodiscard]] double low() const { return usual_min < -usual_max ? -usual_max : usual_min; }
};

struct Effect {
  std::string name;      // the vocabulary of reports and store
  std::string sentence;  // for a person
  std::vector<Need> needs;
  std::vector<EffectParameter> parameters;
  /// Deviation per unit of parameter `k` (in the parameter's own unit) at `moment`. Asked only for
  /// moments that have what `needs` lists.
  Deviation (*basis)(const Moment& moment, int k) = nullptr;
  /// Of an effect with a memory: fills in what `moment` remembers at the shapes, which stand in
  /// `values` where the parameters have them. `history`: may be none.
  void (*recall)(Moment& moment, const Eigen::VectorXd& values, const Conditions& at,
                 const History* history) = nullptr;
};

/// Whether parameter `k` is a shape: effects that have one remember the path or the temperatures.
bool is_shape(const Effect& effect, int k);

/// Each shape in the middle of its usual range, on a scale of ratios; 0 for the other parameters.
Eigen::VectorXd usual_shapes(const Effect& effect);

/// Whether the machine has what parameter `k` acts on; no shape. Proof:
/// tests/core/model/effects_of_machines_test.cpp.
bool exists(const Effect& effect, int k, const Machine& machine);
bool exists(const Effect& effect, const Machine& machine);
/// Throws InputError that lists the effects which the machine has, unless this is one.
void require_effect(const Effect& effect, const Machine& machine);

/// What the effect does on these drives or guides (from 0), in the machine's words: "the x axis is
/// bent: y errs with the square of x"; of most machines the effect's own sentence. Proof: as
/// exists().
std::string sentence_of(const Effect& effect, const Machine& machine,
                        const std::vector<int>& rails);

/// All effects, in the order of reports. `name` is unique.
std::span<const Effect> effect_catalogue();

/// Throws NotFoundError that lists the names there are.
const Effect& find_effect(const std::string& name);

// One effect, one file under effects/.
Effect lead_scale();
Effect lead_curvature();
Effect screw_periodic();
Effect backlash();
Effect thermal_growth();
Effect axis_crosstalk();
Effect platform_load();
Effect guide_bow();
Effect guide_yaw();
Effect hysteresis();
Effect lagged_growth();
Effect move_memory();
Effect tracker_drift();
Effect tracker_scale();

/// One parameter a rail: "k_1", "k_2", "k_3".
std::vector<EffectParameter> one_per_rail(const std::string& letter, const std::string& unit,
                                          double usual_max, On on = On::drive);

}  // namespace trammel
