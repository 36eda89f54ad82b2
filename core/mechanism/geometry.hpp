#pragma once
// The 3-PRR's parameters: the paper's 18 and the three rail offsets that complete them.

#include <Eigen/Core>
#include <array>
#include <string>
#include <string_view>

#include "core/mechanism/pose.hpp"

namespace trammel {

inline constexpr int kChains = 3;

/// One chain A_i B_i C_i. Rail direction u = (cos alpha, sin alpha), normal n = (-sin alpha, cos
/// alpha).
///   B_i = (l + l_zero - R) u + h n,   C_i = O_C + r (cos(beta + phi), sin(beta + phi)),   |C_i -
///   B_i| = S
struct Chain {
  double alpha_rad = 0;
  double beta_rad = 0;
  double r_mm = 0;
  double S_mm = 0;
  double l_zero_mm = 0;  // joint zero: adds to the displacement (the paper's delta l)
  double R_mm = 0;
  double h_mm = 0;  // the rail's line passes the origin O_A at this distance
};

struct Geometry {
  std::array<Chain, kChains> chains;
};

/// Order of every parameter vector: alpha_1 beta_1 r_1 S_1 l_1 R_1 alpha_2 … R_3 (the paper's 18,
/// rad and mm), then h_1 h_2 h_3 [mm].
inline constexpr int kPaperParameters = 18;
inline constexpr int kGeometryParameters = 21;
using GeometryVector = Eigen::Matrix<double, kGeometryParameters, 1>;

/// Names, kinds and size expected of machining, in the order above.
struct GeometryParameter {
  std::string name;       // "alpha_1", …, "h_3"
  int chain = 0;          // 0, 1, 2
  bool is_angle = false;  // rad inside, deg outside; else mm
  double tolerance = 0;   // one standard deviation of machining and assembly, rad or mm
};
const std::array<GeometryParameter, kGeometryParameters>& geometry_parameters();

GeometryVector to_vector(const Geometry& geometry);
Geometry from_vector(const GeometryVector& values);

/// A robot as its maker states it.
struct Limits {
  double l_min_mm = 0;
  double l_max_mm = 600;
};

struct Mechanism {
  Geometry geometry;
  double screw_lead_mm = 10;
  Pose home;  // pose at which the stage was zeroed: s_i = l_i - l_i(home)
  Limits limits;
};

/// The paper's robot: R = 733, S = 430, r = 100 mm, alpha = 270, 30, 150 deg, beta = 30, 150, 270
/// deg.
Mechanism paper_mechanism();

/// Throws InputError that names the first field which is not finite, or a length that is not
/// positive.
void validate(const Mechanism& mechanism);

}  // namespace trammel
