#pragma once
// Physical effects: what is added to the geometry. Each is data plus one function; all are linear
// in their parameters, so that formula and derivative are the same function.

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/mechanism/geometry.hpp"
#include "core/mechanism/pose.hpp"

namespace trammel {

/// Under what an effect acts at one reading.
struct Moment {
  Displacements l_mm = {};         // commanded
  Displacements s_mm = {};         // l - l(home)
  Eigen::Vector3d direction = {};  // sign(cmd - from) per rail: -1, 0, 1
  Displacements travel_mm = {};    // cmd - from
  std::optional<double> temp_degc = {};
  std::optional<double> time_h = {};  // since the campaign's start
  Pose pose = {};                     // where the geometry alone puts the platform
  Eigen::Matrix3d J_V = {};           // dX/dl at that pose
  Eigen::Vector3d theta_rad = {};     // link angles at that pose
  double screw_lead_mm = 10;
};

/// What one effect changes at one reading: displacements, rail offsets, and the reading itself.
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

struct EffectParameter {
  std::string name;  // as in the report: "k_1"
  std::string unit;
  int rail = -1;         // 0, 1, 2; -1 when it belongs to no rail
  double usual_max = 0;  // beyond it a fitted value is unusual (weak: flagged, not refused)
  double usual_min =
      -std::numeric_limits<double>::infinity();  // replaced by -usual_max when not stated
  bool joined = false;  // enters and leaves a model with the parameter before it
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
};

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
Effect tracker_drift();
Effect tracker_scale();

/// One parameter a rail: "k_1", "k_2", "k_3".
std::vector<EffectParameter> one_per_rail(const std::string& letter, const std::string& unit,
                                          double usual_max);

}  // namespace trammel
