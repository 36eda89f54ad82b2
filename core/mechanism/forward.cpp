#include "core/mechanism/forward.hpp"

#include <Eigen/LU>
#include <cmath>

#include "core/mechanism/displacements.hpp"

namespace trammel {

namespace {

constexpr double kTolerance = 1e-12;         // relative to the displacement, mm
constexpr double kRoundingMm = 1e-11;        // what a step that no longer improves may leave
constexpr double kSingularCondition = 1e-9;  // |det J_F2| / r below this: no unique step
constexpr int kMaxIterations = 50;
constexpr int kMaxHalvings = 20;

/// Displacements (4) at a pose X and the velocity equation (6) there, J_F1 dl = J_F2 dX, in the
/// rails' frames: one sine and cosine for all chains.
struct At {
  bool reached = false;
  int chain = 0;  // out of reach
  Eigen::Vector3d l_mm, J_F1_diagonal;
  Eigen::Matrix3d J_F2;

  [[nodiscard]] InverseResult links() const {
    InverseResult result{.status = InverseResult::Status::ok, .l_mm = l_mm};
    for (Eigen::Index i = 0; i < kChains; ++i) {
      result.theta_rad[i] = std::atan2(J_F2(i, 1), J_F2(i, 0));
    }
    return result;
  }
};

At at_pose(const RailFrames& rails, const Eigen::Vector3d& X) {
  At at;
  const double sine = std::sin(X[2]), cosine = std::cos(X[2]);
  for (std::size_t i = 0; i < kChains; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const double ca = rails.ca[i], sa = rails.sa[i], S = rails.S_mm[i];
    const double arm_u = rails.k1[i] * cosine - rails.k2[i] * sine;
    const double arm_n = rails.k2[i] * cosine + rails.k1[i] * sine;
    const double along = X[0] * ca + X[1] * sa + arm_u + rails.R_mm[i];
    const double across = X[1] * ca - X[0] * sa + arm_n - rails.h_mm[i];
    const double square = (S - across) * (S + across);
    if (!(square >= 0)) {
      at.chain = static_cast<int>(i);
      return at;
    }
    const double reach = std::sqrt(square);
    at.l_mm[row] = along - reach - rails.l_zero_mm[i];
    const double cu = reach / S, cn = across / S;  // the link's direction
    at.J_F1_diagonal[row] = cu;
    at.J_F2.row(row) << cu * ca - cn * sa, cu * sa + cn * ca, cn * arm_u - cu * arm_n;
  }
  at.reached = true;
  return at;
}

}  // namespace

ForwardResult forward(const RailFrames& rails, const Displacements& l_mm, const Pose& start) {
  ForwardResult result;
  Eigen::Vector3d X = start.vector();
  At at = at_pose(rails, X);
  if (!l_mm.allFinite() || !at.reached) {
    result.status = ForwardResult::Status::unreachable;
    result.chain = at.chain;
    return result;
  }
  const double tolerance = kTolerance * std::max(1.0, l_mm.cwiseAbs().maxCoeff());
  const double arm_mm = std::hypot(rails.k1[0], rails.k2[0]);
  double previous = INFINITY;
  for (; result.iterations < kMaxIterations; ++result.iterations) {
    const Eigen::Vector3d missing = l_mm - at.l_mm;
    const double gap = missing.cwiseAbs().maxCoeff(&result.chain);
    if (gap <= tolerance || (gap <= kRoundingMm && gap >= previous)) {
      result.status = ForwardResult::Status::ok;
      result.chain = 0;
      result.pose = Pose::from(X);
      result.at = at.links();
      return result;
    }
    previous = gap;
    if (std::abs(at.J_F2.determinant()) < kSingularCondition * arm_mm) {
      result.status = ForwardResult::Status::singular;
      return result;
    }
    Eigen::Vector3d step = at.J_F2.inverse() * at.J_F1_diagonal.cwiseProduct(missing);
    At next;
    for (int halving = 0; halving < kMaxHalvings; ++halving, step *= 0.5) {
      next = at_pose(rails, X + step);
      if (next.reached) break;
    }
    if (!next.reached) {
      result.status = ForwardResult::Status::unreachable;
      result.chain = next.chain;
      return result;
    }
    X += step;
    at = next;
  }
  return result;
}

ForwardResult forward(const Geometry& geometry, const Displacements& l_mm, const Pose& start) {
  return forward(rail_frames(geometry), l_mm, start);
}

std::vector<ForwardResult> forward(const Geometry& geometry, std::span<const Displacements> l_mm,
                                   const Pose& start) {
  std::vector<ForwardResult> results;
  results.reserve(l_mm.size());
  const RailFrames rails = rail_frames(geometry);
  for (const Displacements& l : l_mm) results.push_back(forward(rails, l, start));
  return results;
}

}  // namespace trammel
