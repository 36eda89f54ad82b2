#include "core/diagnose/plausible.hpp"

#include <cmath>
#include <cstdio>
#include <vector>

#include "core/diagnose/residual_space.hpp"
#include "core/linear/decompositions.hpp"
#include "core/linear/products.hpp"
#include "core/measure/lie.hpp"
#include "core/plane/rigid.hpp"
#include "core/statistics/limits.hpp"

namespace trammel {

namespace {

/// Of a named effect's terms that readings do not need the base takes up what there is of them:
/// with crosstalk of six terms, of which three are named, it was 6.2 tolerances off
/// (rounds_test.cpp).
constexpr double kTakenUp = 4.0 / 3;
constexpr double kWorst = kBuilt * kTakenUp;

Eigen::Vector2d along(double angle_rad) { return {std::cos(angle_rad), std::sin(angle_rad)}; }
Eigen::Vector2d across(double angle_rad) { return {-std::sin(angle_rad), std::cos(angle_rad)}; }

Eigen::Vector2d turned(const Eigen::Vector2d& v, double angle_rad) {
  return v.x() * along(angle_rad) + v.y() * across(angle_rad);
}

std::vector<Eigen::Vector2d> platform_joints(const Geometry& geometry) {
  std::vector<Eigen::Vector2d> joints;
  for (const Chain& c : geometry.chains) joints.emplace_back(c.r_mm * along(c.beta_rad));
  return joints;
}

/// `stated`, moved as a whole to where it is closest to `fitted`; the joint zeros are the fitted
/// ones.
Geometry laid_onto(Geometry stated, const Geometry& fitted) {
  const std::vector<Eigen::Vector2d> body = platform_joints(stated), seen = platform_joints(fitted);
  const PlanarFit platform = fit_planar(body, seen);
  double turn_rad = 0;
  for (std::size_t i = 0; i < kChains; ++i) {
    turn_rad += poses::wrapped(fitted.chains[i].alpha_rad - stated.chains[i].alpha_rad) / kChains;
  }
  Eigen::MatrixXd normals(kChains, 2);
  Eigen::VectorXd offsets(kChains);
  for (std::size_t i = 0; i < kChains; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    normals.row(row) = across(stated.chains[i].alpha_rad + turn_rad).transpose();
    offsets[row] = fitted.chains[i].h_mm - stated.chains[i].h_mm;
  }
  const Eigen::VectorXd shift_mm = least_squares(normals, offsets);
  for (std::size_t i = 0; i < kChains; ++i) {
    Chain& c = stated.chains[i];
    const Chain& is = fitted.chains[i];
    const Eigen::Vector2d joint = platform.shift_mm + turned(body[i], platform.turn_rad);
    c.alpha_rad += turn_rad;
    c.h_mm += normals.row(static_cast<Eigen::Index>(i)).dot(shift_mm);
    c.r_mm = joint.norm();
    c.beta_rad = is.beta_rad - poses::wrapped(is.beta_rad - std::atan2(joint.y(), joint.x()));
    c.l_zero_mm = is.l_zero_mm;
  }
  return stated;
}

/// What a frame, a reflector's place, an attitude and the homing change of a geometry, to first
/// order; shape (21, 9), in rad and mm.
Eigen::MatrixXd changes_of_frames(const Geometry& geometry) {
  Eigen::MatrixXd changes = Eigen::MatrixXd::Zero(kGeometryParameters, 9);
  for (int i = 0; i < kChains; ++i) {
    const Chain& c = geometry.chains[static_cast<std::size_t>(i)];
    const int alpha = 6 * i, beta = alpha + 1, r = alpha + 2, l = alpha + 4;
    const int h = kPaperParameters + i;
    changes.block<1, 2>(l, 0) = along(c.alpha_rad).transpose();
    changes.block<1, 2>(h, 0) = across(c.alpha_rad).transpose();
    changes(alpha, 2) = 1;
    changes.block<1, 2>(r, 3) = along(c.beta_rad).transpose();
    changes.block<1, 2>(beta, 3) = across(c.beta_rad).transpose() / c.r_mm;
    changes(beta, 5) = 1;
    changes(l, 6 + i) = 1;
  }
  return changes;
}

/// An orthonormal basis of what the columns of `of` do not reach.
Eigen::MatrixXd complement(const Eigen::MatrixXd& of) {
  const Eigen::MatrixXd reached = orthonormal_basis(of, 1e-9);
  const SymmetricEigen eigen = symmetric_eigen(product_transposed(reached, reached));
  return eigen.vectors.leftCols(of.rows() - reached.cols());  // their values are 0, the others' 1
}

}  // namespace

BaseDistance base_distance(const GeometryFit& fit) {
  BaseDistance distance;
  if (fit.model.nominal.kind->chain != &kPrrChain)
    return distance;  // what lays the others on is not known
  const Geometry fitted = fit.model.geometry();
  const GeometryVector off =
      to_vector(fitted) - to_vector(laid_onto(geometry_of(fit.model.nominal), fitted));
  const Eigen::MatrixXd frames = changes_of_frames(fitted);
  const auto n = static_cast<Eigen::Index>(fit.parameters.size());
  Eigen::VectorXd z = Eigen::VectorXd::Zero(n);
  Eigen::MatrixXd N = Eigen::MatrixXd::Zero(n, frames.cols() + n);
  for (Eigen::Index j = 0; j < n; ++j) {
    const FreeParameter& p = fit.parameters[static_cast<std::size_t>(j)];
    if (p.kind == FreeParameter::Kind::geometry) {
      z[j] = off[p.index] / p.scale;
      N.row(j).head(frames.cols()) = frames.row(p.index) / p.scale;
    } else {
      N(j, frames.cols() + j) = 1;
    }
  }
  const Eigen::MatrixXd& V = fit.identified.directions;
  const Eigen::MatrixXd U = complement(transposed_product(V, N));
  distance.directions = static_cast<int>(U.cols());
  if (distance.directions == 0) return distance;
  const Eigen::VectorXd variances =
      fit.identified.singular.head(fit.identified.rank).cwiseAbs2().cwiseInverse();
  Eigen::MatrixXd C = weighted_outer(U.transpose(), variances);
  C.diagonal().array() += kWorst * kWorst;
  const Eigen::VectorXd t = transposed_times(U, transposed_times(V, z));
  distance.chi2 = t.dot(solve_symmetric(C, t));
  distance.tolerances = kWorst * std::sqrt(distance.chi2 / distance.directions);
  distance.p = chi2_tail(distance.chi2, distance.directions);
  return distance;
}

std::string in_words(const BaseDistance& distance) {
  const double limit =
      kWorst * std::sqrt(chi2_limit(kImplausible, distance.directions) / distance.directions);
  char text[200];
  std::snprintf(text, sizeof text,
                "the geometry must be %.3g tolerances off the stated one, rms over the %d "
                "combinations that no frame or homing explains (%.2g is the most of a robot built "
                "%g times as badly as stated)",
                distance.tolerances, distance.directions, limit, kWorst);
  return text;
}

}  // namespace trammel
