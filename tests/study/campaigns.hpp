#pragma once
// Campaigns with a hidden effect, made by the virtual robot: what the diagnosis is judged by.
// Nothing here looks at the catalogue that is fitted (core/model); of core/diagnose the points it
// asks for are measured.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/diagnose/next_points.hpp"
#include "core/measure/reading.hpp"
#include "core/simulate/truth.hpp"

namespace trammel::tests {

/// How the campaign was measured.
struct Design {
  std::string name =
      "rich";  // rich: three orientations, all directions; paper: the 80 points as they come
  std::string machine = "3-PRR";
  double reach = 1;  // over the paper's points, orientations and approaches
  int epochs = 1;
  double sigma_xy_mm = 0.010;
  double sigma_phi_deg = 0.004;
  double stated_over_true = 1;  // the sigma written into the campaign, over the tracker's
  double lead_mm = 10;
  double lead_error = 0;       // the screw's true lead is lead_mm (1 + lead_error)
  double correlation = 0;      // of successive readings; below 0: they alternate
  double student = 0;          // degrees of freedom of the noise's t distribution; 0: normal
  double thinning = 1;         // share of the points kept
  int outliers = 0;            // readings that are 0.3 mm off
  bool one_direction = false;  // every rail arrives in + direction
};

/// What the virtual robot does not do: drives that follow the path, a tilted measuring plane.
struct Beyond {
  int drives = 3;
  Eigen::Vector3d play_mm = Eigen::Vector3d::Zero();  // -v mean over radii of (l - F_r) / r
  std::vector<double> radii_mm = {};
  Eigen::Vector3d memory_mm = Eigen::Vector3d::Zero();  // -v dir exp(-|move| / length)
  double memory_length_mm = 5;
  Eigen::Vector3d late_growth_per_k = Eigen::Vector3d::Zero();  // c l (F - 20), tau dF/dt = T - F
  double late_s = 1800;
  double tilt = 0;  // lengths along the azimuth shrink by this share
  double azimuth_rad = 0;
};

/// A kind of error, drawn at random: which rails, sign, phase.
struct Family {
  std::string name;  // of the catalogue, or of what is outside it
  bool in_catalogue = true;
  void (*hide)(simulate::Truth& truth, double size, std::uint64_t seed) = nullptr;  // size 1: usual
  void (*beyond)(Beyond& beyond, double size, std::uint64_t seed) = nullptr;
};
const std::vector<Family>& families();

struct HiddenCase {
  Campaign campaign;
  std::vector<std::string> hidden;  // names, rising; empty: nothing
  bool in_catalogue = true;
  simulate::Truth truth;  // what was hidden
  Beyond beyond;
  std::vector<Reading> still;    // the same readings without noise
  std::vector<std::size_t> bad;  // places of readings that are wrong for certain
};

/// A campaign in which all of `hidden` act. Each is sized so that noise-free readings keep a chi^2
/// of rho^2 once the base is refitted to them (so rho is effect over noise, after the refit); 0
/// where nothing can survive. Geometry of machining size, epochs, directions, temperatures and
/// noise are drawn from `seed`.
HiddenCase make_case(const Design& design, const std::vector<const Family*>& hidden, double rho,
                     std::uint64_t seed);

/// The campaign with these points measured on the same machine afterwards, in an epoch of their
/// own.
Campaign with_points(const HiddenCase& hidden, const NextPoints& next);

const Family& family(const std::string& name);

/// What was hidden, in the words of a report ("backlash w_1"), in their units; 0 where nothing was.
std::map<std::string, double> parameters_of(const HiddenCase& hidden);

/// How a machine of this kind is measured: a UVW stage of +-5 mm on a thirtieth of the paper's
/// square by an instrument of 0.5 um; an XY stage and an axis at random places of +-100 mm, by the
/// same; others as the paper's.
Design design_of(const std::string& machine);

HiddenCase hide(const std::vector<std::string>& names, double rho, std::uint64_t seed,
                const Design& design = {});

}  // namespace trammel::tests
