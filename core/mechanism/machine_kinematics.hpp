#pragma once
// What follows from the closures of a machine's chains, once for all kinds of machine:
//   F(p, q, X) = 0,   J_V = dX/dq = -F_X^-1 F_q,   J_e = dX/dp = -F_X^-1 F_p
// The kernels of the 3-PRR (displacements, forward, error_rows) are its fast path, held to these.

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "core/mechanism/machine.hpp"
#include "core/mechanism/velocity.hpp"

namespace trammel {

inline constexpr int kMostParameters = 3 * static_cast<int>(kMostChainParameters);
/// Rows x, y [mm], phi [rad]; a column for each of parameters_of(kind), mm and rad.
using ParameterColumns =
    Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kMostParameters>;

/// F and its derivatives at one pose. A coordinate that the machine has not is held where it is:
/// its row of F_X is that of the unit matrix, its others are 0.
struct Closures {
  Eigen::Vector3d F = Eigen::Vector3d::Zero();  // mm
  Eigen::Matrix3d F_X = Eigen::Matrix3d::Identity();
  Eigen::Vector3d F_q = Eigen::Vector3d::Zero();  // f_i depends on q_i alone
  ParameterColumns F_p;
};
Closures closures(const Machine& machine, const Displacements& q_mm, const Pose& X);

/// dX/dq, shape (3, 3), mm and rad per mm; zero for drives and coordinates that the machine has
/// not. Precondition of both: the pose is not singular. Proof: golden numbers of an independent
/// program, the kernels of the 3-PRR to 1e-12, finite differences of forward() (machine_test.cpp).
Eigen::Matrix3d velocity_jacobian(const Closures& at);
ParameterColumns error_jacobian(const Closures& at);

/// As for the 3-PRR (velocity.hpp); `parallel` from F_X with phi scaled by the mean r, over sqrt(3)
/// where phi is a coordinate; `serial` is min |df_i/dq_i|.
Singularity singularity(const Machine& machine, const Closures& at);
/// Below this margin nothing is computed: an error of a nanometre in a drive is one of a millimetre
/// of the platform, and what follows is rounding.
inline constexpr double kSingularMargin = 1e-6;

/// The side of the parallel singularities on which a pose lies: the sign of det F_X. Who passes
/// from one to the other passes a singular pose; +1 or -1.
int assembly(const Closures& at);

/// Drives at a pose, as they move with the platform.
struct DrivesAt {
  int missed = kChains;                        // the first chain out of reach; kChains: none
  Displacements q_mm = Displacements::Zero();  // this and the rest where all reach
  Eigen::Vector3d velocity_mm_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d acceleration_mm_s2 = Eigen::Vector3d::Zero();
  /// Of links or cylinders against X: rad, rad/s, rad/s^2. Nothing where the kind has none.
  std::optional<std::array<Eigen::Vector3d, 3>> angle;

  [[nodiscard]] bool reached() const { return missed == kChains; }
};

/// q in closed form, chain by chain; its rates under X' and X'' by dual numbers in time: for the
/// 3-PRR Eqs. 4 to 8 of Zhang et al. 2024. Proof: finite differences (machine_test.cpp).
DrivesAt drives_at(const Machine& machine, const Pose& X,
                   const Eigen::Vector3d& X_dot = Eigen::Vector3d::Zero(),
                   const Eigen::Vector3d& X_ddot = Eigen::Vector3d::Zero());

/// One pose against the machine's limits and the assembly of its home.
struct [[nodiscard]] Reach {
  enum class Status { ok, not_finite, unreachable, limit, singular, other_assembly };
  Status status = Status::not_finite;
  int chain = 0;              // unreachable: the chain; else the drive nearest to a limit, from 0
  double stroke_left_mm = 0;  // to the nearest end of that drive; negative beyond it
  DrivesAt at;                // these and the rest where all chains reach the pose
  Singularity singularity;
  int assembly = 0;  // +1: home's; -1: the other; 0: at a singular pose, or home is out of reach

  [[nodiscard]] bool ok() const { return status == Status::ok; }
};
/// Status is the worst that holds: singular, other assembly, limit. Proof: workspace_test.cpp.
Reach reach(const Machine& machine, const Pose& pose);
/// "ok", "not finite", "unreachable", "limit", "singular", "other assembly".
const char* name_of(Reach::Status status);
/// "home", "other", "none" at a singular pose.
const char* assembly_name(int assembly);

struct [[nodiscard]] MachinePose {
  enum class Status { ok, unreachable, singular };
  Status status = Status::unreachable;
  Pose pose;           // ok only; phi in [-pi, pi]
  int iterations = 0;  // of Newton's method, over all starts
  int chain = 0;       // unreachable: the chain that is farthest off, from 0

  [[nodiscard]] bool ok() const { return status == Status::ok; }
};

/// "ok", "unreachable", "singular".
const char* name_of(MachinePose::Status status);

/// Pose at drives `q_mm` in the assembly of `start`, of several the one that the drives' straight
/// way from `start` leads to where it leads somewhere, else the first found from poses strewn about
/// the stroke.
///
///   X <- X - F_X^-1 F,   stop when max |F| <= 1e-12 max(1, |q|)
/// A step is halved while it crosses a singular pose or makes F larger. Unreachable: no start leads
/// to such a pose. Singular: `start` is. Proof: every pose of the stroke is found again
/// (machine_test.cpp).
MachinePose forward(const Machine& machine, const Displacements& q_mm, const Pose& start);

}  // namespace trammel
