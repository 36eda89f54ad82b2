#include "core/mechanism/forward.hpp"

#include <cmath>

#include "core/linear/decompositions.hpp"
#include "core/mechanism/velocity.hpp"

namespace trammel {

namespace {

constexpr double kTolerance = 1e-12;         // relative to the displacement, mm
constexpr double kRoundingMm = 1e-11;        // what a step that no longer improves may leave
constexpr double kSingularCondition = 1e-9;  // |det J_F2| / r below this: no unique step
constexpr int kMaxIterations = 50;  // a bound: far from singular poses Newton converges at once
constexpr int kMaxHalvings = 20;    // a step of a millionth is none

}  // namespace

ForwardResult forward(const RailFrames& rails, const Displacements& l_mm, const Pose& start) {
  ForwardResult result;
  Eigen::Vector3d X = start.vector();
  ChainsAtPose at = chains_at(rails, X);
  if (!l_mm.allFinite() || !at.reached()) {
    result.status = ForwardResult::Status::unreachable;
    result.chain = at.reached() ? 0 : at.missed;
    return result;
  }
  const double tolerance = kTolerance * std::max(1.0, l_mm.cwiseAbs().maxCoeff());
  double previous = INFINITY;
  for (; result.iterations < kMaxIterations; ++result.iterations) {
    const Eigen::Vector3d missing = l_mm - at.l_mm;
    const double gap = missing.cwiseAbs().maxCoeff(&result.chain);
    if (gap <= tolerance || (gap <= kRoundingMm && gap >= previous)) {
      result.status = ForwardResult::Status::ok;
      result.chain = 0;
      result.pose = Pose::from(X);
      result.at = at;
      return result;
    }
    previous = gap;
    const VelocityEquation velocity = velocity_equation(rails, at);
    if (std::abs(determinant(velocity.J_F2)) < kSingularCondition * rails.r_mm[0]) {
      result.status = ForwardResult::Status::singular;
      return result;
    }
    Eigen::Vector3d step = inverse(velocity.J_F2) * velocity.J_F1_diagonal.cwiseProduct(missing);
    ChainsAtPose next;
    for (int halving = 0; halving < kMaxHalvings; ++halving, step *= 0.5) {
      next = chains_at(rails, X + step);
      if (next.reached()) break;
    }
    if (!next.reached()) {
      result.status = ForwardResult::Status::unreachable;
      result.chain = next.missed;
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

}  // namespace trammel
