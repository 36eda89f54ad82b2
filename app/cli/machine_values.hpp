#pragma once
// Numbers of a machine as a person types and reads them: as many as it has drives.

#include <string>
#include <vector>

#include "core/mechanism/machine.hpp"

namespace trammel::cli {

/// Numbers typed apart or with commas. Throws UsageError where those of one word, "10,5,3", are not
/// one pose of the machine, or no numbers.
std::vector<double> numbers_of(const Machine& machine, const std::vector<std::string>& typed,
                               const char* field);

/// As many numbers at a time as the machine has drives; 0 for those it has not. Throws UsageError
/// that names `field` for a group that is not whole and a number that is not finite.
/// Proof of all: mechanism_test.cpp, any_machine_test.cpp.
std::vector<Eigen::Vector3d> groups(const Machine& machine, const std::vector<double>& values,
                                    const char* field);

/// x, y in mm and phi in deg (or per s, or s^2) as typed, in rad inside.
std::vector<Eigen::Vector3d> typed_poses(const Machine& machine, const std::vector<double>& typed,
                                         const char* field);

/// The coordinates that a machine has not stand at home.
Pose pose_on(const Machine& machine, const Eigen::Vector3d& values);

/// "261.8112, 261.8112, 261.8112": of drives or coordinates.
std::string cells_of(const Machine& machine, const Eigen::Vector3d& v, int width, int decimals,
                     const char* between = " ");

/// "      x mm       y mm    phi deg" and "     l1 mm      l2 mm", as far as the machine has them.
std::string pose_header(const Machine& machine, int width);
std::string drive_header(const Machine& machine, int width);

/// Half the square that maps and tables cover where nobody says: 100 mm, or half the longest stroke
/// where that is less.
double usual_half_width_mm(const Machine& machine);

/// And between their places: 10 mm, or a tenth of the half-width of a square below 20 mm.
double usual_step_mm(double half_width_mm);

/// x, y in mm, phi in deg.
Eigen::Vector3d shown_pose(const Pose& pose);

}  // namespace trammel::cli
