#include "core/calibrate/gp.hpp"

#include <cmath>
#include <utility>

#include "core/error.hpp"
#include "core/linear/decompositions.hpp"
#include "core/linear/products.hpp"

namespace trammel {

namespace {

constexpr int kLengths = 12, kRatios = 19;  // starts of the search for the likeliest
constexpr double kFirstLengthMm = 20, kLastLengthMm = 900;  // a grid step of the paper to a stroke
constexpr double kSmallestSignalMm = 1e-9;  // of a constant column: keeps the logarithm finite

Eigen::MatrixXd correlation(const std::vector<double>& x, const std::vector<double>& y,
                            double length_mm) {
  const auto n = static_cast<Eigen::Index>(x.size());
  const Eigen::Map<const Eigen::ArrayXd> X(x.data(), n), Y(y.data(), n);
  Eigen::MatrixXd C(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    C.col(j) = ((X - X[j]).square() + (Y - Y[j]).square()) / (-2 * length_mm * length_mm);
  }
  return C.array().exp();
}

double length_at(int k) {
  return kFirstLengthMm *
         std::pow(kLastLengthMm / kFirstLengthMm, static_cast<double>(k) / (kLengths - 1));
}
double ratio_at(int k) { return std::pow(10.0, -6.0 + 0.5 * k); }

/// log marginal likelihood with the best signal size, for C = U diag(c) U' and y already in U's
/// axes.
double log_likelihood(const Eigen::ArrayXd& eigenvalues, const Eigen::ArrayXd& y_turned,
                      double ratio, double& signal2) {
  const Eigen::ArrayXd total = eigenvalues.max(0) + ratio;
  const auto n = static_cast<double>(total.size());
  signal2 = std::max((y_turned.square() / total).sum() / n, kSmallestSignalMm * kSmallestSignalMm);
  return -0.5 * (n * std::log(signal2) + total.log().sum());
}

}  // namespace

Eigen::VectorXd covariances(const GpMap& map, const GpJoint& joint, Place at) {
  const auto n = static_cast<Eigen::Index>(map.x_mm.size());
  const Eigen::Map<const Eigen::ArrayXd> X(map.x_mm.data(), n), Y(map.y_mm.data(), n);
  return joint.signal_mm * joint.signal_mm *
         (((X - at.x_mm).square() + (Y - at.y_mm).square()) /
          (-2 * joint.length_mm * joint.length_mm))
             .exp();
}

Eigen::MatrixXd covariance(const GpMap& map, const GpJoint& joint) {
  Eigen::MatrixXd K =
      joint.signal_mm * joint.signal_mm * correlation(map.x_mm, map.y_mm, joint.length_mm);
  K.diagonal().array() += joint.noise_mm * joint.noise_mm;
  return K;
}

GpMap fit_gp(std::span<const JointSample> samples) {
  require_places(samples, 3);
  if (samples.size() > kMostGpSamples) {
    throw InputError({.what = "there are too many readings for a Gaussian process",
                      .got = std::to_string(samples.size()),
                      .expected = "at most " + std::to_string(kMostGpSamples),
                      .hint = "rbf and geometry take any number; or name fewer sessions"});
  }
  GpMap map;
  const auto n = static_cast<Eigen::Index>(samples.size());
  Eigen::MatrixX3d y(n, 3);
  for (Eigen::Index k = 0; k < n; ++k) {
    const JointSample& s = samples[static_cast<std::size_t>(k)];
    map.x_mm.push_back(s.x_mm);
    map.y_mm.push_back(s.y_mm);
    y.row(k) = s.error_mm.transpose();
  }
  const Eigen::RowVector3d mean = y.colwise().mean();
  y.rowwise() -= mean;
  std::array<double, 3> best;
  best.fill(-INFINITY);
  for (int l = 0; l < kLengths; ++l) {
    const double length = length_at(l);
    const SymmetricEigen eigen = symmetric_eigen(correlation(map.x_mm, map.y_mm, length));
    const Eigen::MatrixXd turned = transposed_product(eigen.vectors, y);
    for (int r = 0; r < kRatios; ++r) {
      for (int i = 0; i < 3; ++i) {
        double signal2 = 0;
        const double likelihood = log_likelihood(eigen.values, turned.col(i), ratio_at(r), signal2);
        auto& winner = best[static_cast<std::size_t>(i)];
        if (likelihood <= winner) continue;
        winner = likelihood;
        map.joints[static_cast<std::size_t>(i)] = {.mean_mm = mean[i],
                                                   .length_mm = length,
                                                   .signal_mm = std::sqrt(signal2),
                                                   .noise_mm = std::sqrt(signal2 * ratio_at(r)),
                                                   .weights = {}};
      }
    }
  }
  for (int i = 0; i < 3; ++i) {
    GpJoint& joint = map.joints[static_cast<std::size_t>(i)];
    joint.weights = Cholesky(covariance(map, joint)).solve(Eigen::VectorXd(y.col(i)));
  }
  return map;
}

Eigen::Vector3d predict(const GpMap& map, Place at) {
  Eigen::Vector3d error;
  for (int i = 0; i < 3; ++i) {
    const GpJoint& joint = map.joints[static_cast<std::size_t>(i)];
    error[i] = joint.mean_mm + covariances(map, joint, at).dot(joint.weights);
  }
  return error;
}

std::vector<Eigen::Vector3d> uncertainty_mm(const GpMap& map, std::span<const Place> at) {
  std::vector<Eigen::Vector3d> u(at.size());
  for (int i = 0; i < 3; ++i) {
    const GpJoint& joint = map.joints[static_cast<std::size_t>(i)];
    const Cholesky K(covariance(map, joint));
    for (std::size_t q = 0; q < at.size(); ++q) {
      const Eigen::VectorXd k = covariances(map, joint, at[q]);
      const double u2 = joint.signal_mm * joint.signal_mm - k.dot(K.solve(k));
      u[q][i] = std::sqrt(std::max(u2, 0.0));
    }
  }
  return u;
}

}  // namespace trammel
