#include "core/calibrate/geometry_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/error.hpp"
#include "core/linear/decompositions.hpp"
#include "core/linear/products.hpp"
#include "core/linear/singular_values.hpp"
#include "core/measure/bad_readings.hpp"
#include "core/model/predictor.hpp"
#include "core/statistics/limits.hpp"

namespace trammel {

namespace {

constexpr double kJudged = 1e-6;      // of a reading's own three directions: less is fitted exactly
constexpr double kSetAside = 0.5;     // of the worst d2: the worst pulls others, not its own like
constexpr double kRowsPerColumn = 2;  // fewer rows would follow single readings
constexpr double kOwnDirection = 1e-10;  // of the largest eigenvalue of unit columns
constexpr double kStop = 1e-7;           // sigmas that the readings still move
constexpr double kFirstDamping = 1e-8;   // of the largest s^2
constexpr double kLastDamping = 1e4;     // beyond it a step moves nothing
/// sqrt of the median of chi^2(k): how far a reading of k coordinates lies, the middle one of many
constexpr std::array<double, 4> kMedianOfChi = {1, 0.674490, 1.177410, 1.538172};

void require_usable(std::span<const Reading> readings, const PoseSigma& sigma,
                    const Coordinates& measured) {
  if (readings.empty()) {
    throw InputError(
        {.what = "there are no readings to identify from",
         .hint = "readings of set 'identify' are fitted; exclusions may have taken them all"});
  }
  if (!(sigma.of(measured).array() > 0).all()) {
    throw InputError(
        {.what = "the tracker's sigma must be positive",
         .where = {.field = "tracker.sigma_xy_mm, sigma_phi_deg"},
         .got = std::to_string(sigma.each[0]) + " mm, " + std::to_string(sigma.each[2]) + " rad",
         .hint = "leave both out to have the noise estimated from repeats"});
  }
}

[[noreturn]] void unreachable(const Reading& reading) {
  throw InputError({.what = "the model cannot reach the commanded displacements of a reading",
                    .where = {.point = "seq " + std::to_string(reading.seq)},
                    .hint = "check the mechanism's parameters, or exclude the reading"});
}

/// Spread of the readings' residuals in sigmas, from the median, at least 1; `fitted`: columns that
/// took their share of it.
double spread(const Eigen::VectorXd& residual, int coordinates, Eigen::Index fitted = 0) {
  std::vector<double> sizes;
  for (Eigen::Index i = 0; i < residual.size(); i += 3) {
    sizes.push_back(residual.segment<3>(i).norm());
  }
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  const auto rows = static_cast<double>(residual.size() / 3 * coordinates);
  const double left = std::max(1.0, rows - static_cast<double>(fitted)) / rows;
  return std::max(1.0,
                  *middle / kMedianOfChi[static_cast<std::size_t>(coordinates)] / std::sqrt(left));
}

Eigen::VectorXd huber_weights(const Eigen::VectorXd& residual, double scale, double huber) {
  Eigen::VectorXd w(residual.size() / 3);
  for (Eigen::Index i = 0; i < w.size(); ++i) {
    const double size = residual.segment<3>(3 * i).norm() / scale;
    w[i] = size <= huber ? 1.0 : huber / size;
  }
  return w;
}

/// Sum that a step must lower: Huber's with a limit, else the plain sum of squares.
double objective(const Eigen::VectorXd& residual, std::optional<double> huber, double scale) {
  if (!huber) return residual.squaredNorm();
  double sum = 0;
  for (Eigen::Index i = 0; i < residual.size(); i += 3) {
    const double size = residual.segment<3>(i).norm() / scale;
    sum += size <= *huber ? size * size : *huber * (2 * size - *huber);
  }
  return scale * scale * sum;
}

WhitenedSystem weighted(WhitenedSystem system, const Eigen::VectorXd& weights) {
  for (Eigen::Index i = 0; i < weights.size(); ++i) {
    const double root = std::sqrt(weights[i]);
    system.residual.segment<3>(3 * i) *= root;
    system.jacobian.middleRows<3>(3 * i) *= root;
  }
  return system;
}

void add_prior(WhitenedSystem& system, const Eigen::VectorXd& z) {
  const Eigen::Index rows = system.residual.size(), n = z.size();
  system.residual.conservativeResize(rows + n);
  system.jacobian.conservativeResize(rows + n, n);
  system.residual.tail(n) = -z;
  system.jacobian.bottomRows(n).setIdentity();
}

std::optional<WhitenedSystem> system_within_reach(const RobotModel& model,
                                                  std::span<const Reading> readings,
                                                  const PoseSigma& sigma,
                                                  const std::vector<FreeParameter>& parameters) {
  const Eigen::Vector3d s = sigma.of(model.nominal.measured);
  const auto rows = static_cast<Eigen::Index>(3 * readings.size());
  WhitenedSystem system{Eigen::VectorXd(rows),
                        Eigen::MatrixXd(rows, static_cast<Eigen::Index>(parameters.size()))};
  Eigen::Index row = 0;
  const Predictor expected(model);
  for (const Reading& reading : readings) {
    const Prediction at = expected.predict(reading.conditions);
    if (!at.ok()) return std::nullopt;
    system.residual.segment<3>(row) =
        (reading.measured->vector() - at.pose.vector()).cwiseQuotient(s);
    system.jacobian.middleRows<3>(row) =
        derivative(model, parameters, reading.conditions, at, s.cwiseInverse());
    row += 3;
  }
  return system;
}

/// Steps from one linearisation: Gauss-Newton's on the truncated decomposition, and shorter ones.
class Steps {
 public:
  Steps(const WhitenedSystem& system, const Eigen::VectorXd& z) {
    const Identifiable known = identifiable(system.jacobian);
    V_ = known.directions;
    s_ = known.singular.head(known.rank);
    along_ = transposed_times(V_, transposed_times(system.jacobian, system.residual));
    back_ = -without(V_, z);  // minimum change from the start: of z, not of the step
  }

  /// `lambda` in units of the largest s^2; `home`: what readings do not know goes back to the
  /// start.
  [[nodiscard]] Eigen::VectorXd with(double lambda, bool home) const {
    const double damping = s_.size() > 0 ? lambda * s_[0] * s_[0] : 0;
    Eigen::VectorXd scaled = along_;
    for (Eigen::Index k = 0; k < s_.size(); ++k) scaled[k] /= s_[k] * s_[k] + damping;
    Eigen::VectorXd step = times(V_, scaled);
    if (home) step += back_ / (1 + lambda);
    return step;
  }

  /// The most that the undamped step moves the readings along one direction, sigmas.
  [[nodiscard]] double undamped_moves() const {
    return s_.size() > 0 ? along_.cwiseQuotient(s_).cwiseAbs().maxCoeff() : 0;
  }

 private:
  Eigen::MatrixXd V_;
  Eigen::VectorXd s_, along_, back_;
};

}  // namespace

WhitenedSystem whitened_system(const RobotModel& model, std::span<const Reading> readings,
                               const PoseSigma& sigma,
                               const std::vector<FreeParameter>& parameters) {
  for (const Reading& reading : readings) {
    if (!reading.measured) unreachable(reading);
  }
  if (auto system = system_within_reach(model, readings, sigma, parameters)) return *system;
  unreachable(*std::ranges::find_if(
      readings, [&](const Reading& r) { return !predict(model, r.conditions).ok(); }));
}

void hold_unseen(std::vector<FreeParameter>& parameters, const Machine& nominal,
                 std::span<const Reading> readings, const PoseSigma& sigma) {
  const RobotModel model = nominal_model(nominal);
  const Predictor expected(model);
  const Eigen::Vector3d weight = sigma.of(nominal.measured).cwiseInverse();
  std::vector<FreeParameter> unseen;
  for (const FreeParameter& p : parameters) {
    if (p.kind != FreeParameter::Kind::effect) unseen.push_back(p);
  }
  Eigen::VectorXd signal2 = Eigen::VectorXd::Zero(std::ssize(unseen));
  const auto all_seen = [&] { return (signal2.array() > kLeastSignal * kLeastSignal).all(); };
  for (std::size_t k = 0; k < readings.size() && !all_seen(); ++k) {
    const Prediction at = expected.predict(readings[k].conditions);
    if (!at.ok()) continue;  // of a machine that is far from nominal
    signal2 +=
        derivative(model, unseen, readings[k].conditions, at, weight).colwise().squaredNorm();
  }
  Eigen::Index next = 0;
  for (FreeParameter& p : parameters) {
    if (p.kind == FreeParameter::Kind::effect) continue;
    p.held = signal2[next++] <= kLeastSignal * kLeastSignal;
  }
}

void decorrelate(Eigen::Ref<Eigen::MatrixXd> rows, std::span<const Reading> readings, double rho) {
  if (rho == 0) return;
  for (std::size_t i = readings.size(); i-- > 1;) {
    if (readings[i].conditions.epoch != readings[i - 1].conditions.epoch) continue;
    const double kept = std::pow(rho, readings[i].seq - readings[i - 1].seq);
    const auto row = static_cast<Eigen::Index>(3 * i);
    rows.middleRows<3>(row) =
        (rows.middleRows<3>(row) - kept * rows.middleRows<3>(row - 3)) / std::sqrt(1 - kept * kept);
  }
}

int measured_by(const RobotModel& model) {
  return static_cast<int>(std::ranges::count(model.nominal.measured, true));
}

Identifiable identifiable(const Eigen::MatrixXd& whitened_jacobian) {
  SingularValues svd = singular_values(whitened_jacobian);
  Identifiable result;
  result.singular = std::move(svd.singular);
  while (result.rank < result.singular.size() && result.singular[result.rank] > kLeastSignal) {
    ++result.rank;
  }
  result.directions = svd.V.leftCols(result.rank);
  return result;
}

Eigen::MatrixXd covariance(const Identifiable& known) {
  const Eigen::VectorXd s = known.singular.head(known.rank);
  return weighted_outer(known.directions, s.cwiseAbs2().cwiseInverse());
}

GeometryFit fit_geometry(const RobotModel& start, std::span<const Reading> readings,
                         const PoseSigma& sigma, const GeometryFitOptions& options) {
  require_usable(readings, sigma, start.nominal.measured);
  GeometryFit fit;
  const int coordinates = measured_by(start);
  std::optional<double> huber;
  if (options.huber) huber = kHuber[static_cast<std::size_t>(coordinates)];
  fit.parameters = base_parameters(start.nominal, {readings.begin(), readings.end()});
  hold_unseen(fit.parameters, start.nominal, readings, sigma);
  add_effect_parameters(fit.parameters, start);
  fit.model = start;
  fit.z = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(fit.parameters.size()));
  fit.weights = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(readings.size()));
  const auto settled = [&](WhitenedSystem system) {
    decorrelate(system.residual, readings, options.correlation);
    decorrelate(system.jacobian, readings, options.correlation);
    return system;
  };
  fit.system = settled(whitened_system(fit.model, readings, sigma, fit.parameters));

  const auto total = [&](const Eigen::VectorXd& residual, const Eigen::VectorXd& z) {
    return objective(residual, huber, fit.scale) +
           (options.tolerance_prior ? z.squaredNorm() : 0.0);
  };
  double lambda = 0;  // of the largest s^2
  for (; fit.iterations < options.max_iterations; ++fit.iterations) {
    if (huber) {
      fit.scale = spread(fit.system.residual, coordinates);
      fit.weights = huber_weights(fit.system.residual, fit.scale, *huber);
    }
    WhitenedSystem system = weighted(fit.system, fit.weights);
    if (options.tolerance_prior) add_prior(system, fit.z);
    const Steps steps(system, fit.z);
    const double before = total(fit.system.residual, fit.z);
    const auto lowers = [&](bool home) {
      const Eigen::VectorXd step = steps.with(lambda, home);
      const RobotModel model = moved(fit.model, fit.parameters, step);
      auto next = system_within_reach(model, readings, sigma, fit.parameters);
      if (!next) return false;  // a step along what readings hardly know can leave reach
      *next = settled(std::move(*next));
      if (total(next->residual, fit.z + step) > before * (1 + 1e-12) + kStop) return false;
      fit.z += step;
      fit.model = model;
      fit.system = *std::move(next);
      return true;
    };
    bool better = false;
    for (; !better && lambda <= kLastDamping; lambda = std::max(kFirstDamping, 10 * lambda)) {
      // where the model lacks much, the way back can cost what the step gains
      better = lowers(true) || lowers(false);
      fit.damped += better && lambda > 0 ? 1 : 0;
    }
    if (steps.undamped_moves() < kStop) {
      fit.status = GeometryFit::Status::converged;
      break;
    }
    if (!better) {
      fit.status = GeometryFit::Status::stalled;
      break;
    }
    lambda = lambda <= 100 * kFirstDamping ? 0 : lambda / 100;  // the loop left it ten times up
  }
  WhitenedSystem system = weighted(fit.system, fit.weights);
  if (options.tolerance_prior) add_prior(system, fit.z);
  fit.identified = identifiable(system.jacobian);
  fit.covariance = covariance(fit.identified);
  fit.chi2 = fit.system.residual.squaredNorm();
  fit.dof = static_cast<int>(coordinates * std::ssize(readings) - fit.identified.rank);
  return fit;
}

namespace {

/// Orthonormal columns that span those of J, without what is theirs but for rounding.
Eigen::MatrixXd orthonormal(Eigen::MatrixXd J) {
  J.colwise().normalize();
  const SymmetricEigen eigen = symmetric_eigen(gram(J));
  const double least = kOwnDirection * eigen.values.maxCoeff();
  Eigen::MatrixXd kept(J.cols(), (eigen.values.array() > least).count());
  for (Eigen::Index k = 0, next = 0; k < J.cols(); ++k) {
    if (eigen.values[k] > least)
      kept.col(next++) = eigen.vectors.col(k) / std::sqrt(eigen.values[k]);
  }
  return product(J, kept);
}

/// What may move with a reading: the directions that the fit knows, and a smooth field of each
/// coordinate.
Eigen::MatrixXd with_smooth_field(const GeometryFit& fit, std::span<const Reading> readings) {
  const Eigen::MatrixXd known = product(fit.system.jacobian, fit.identified.directions);
  std::vector<Pose> targets;
  for (const Reading& r : readings) targets.push_back(r.target);
  const Eigen::MatrixXd field = smooth_terms(targets);
  const Eigen::Index n = known.cols(), terms = field.cols();
  const Coordinates& measured = fit.model.nominal.measured;
  const auto fields = static_cast<Eigen::Index>(std::ranges::count(measured, true));
  if (kRowsPerColumn * static_cast<double>(n + fields * terms) >
      static_cast<double>(field.rows() * fields))
    return orthonormal(known);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(known.rows(), n + fields * terms);
  J.leftCols(n) = known;
  Eigen::Index next = n;
  for (Eigen::Index c = 0; c < 3; ++c) {
    if (!measured[static_cast<std::size_t>(c)]) continue;
    for (Eigen::Index i = 0; i < field.rows(); ++i)
      J.block(3 * i + c, next, 1, terms) = field.row(i);
    next += terms;
  }
  return orthonormal(std::move(J));
}

}  // namespace

std::vector<OutlyingReading> outlying_readings(const GeometryFit& fit,
                                               std::span<const Reading> readings,
                                               double false_alarm) {
  TRAMMEL_ASSERT(fit.weights.size() == static_cast<Eigen::Index>(readings.size()));
  const int coordinates = measured_by(fit.model);
  const double limit = chi2_limit(false_alarm / static_cast<double>(readings.size()), coordinates);
  const Eigen::MatrixXd J = with_smooth_field(fit, readings);
  // the normal equations of the readings that are left
  WhitenedSystem counted{fit.system.residual, J};
  counted = weighted(std::move(counted), fit.weights);
  Eigen::MatrixXd normal = gram(counted.jacobian);
  Eigen::VectorXd right = transposed_times(counted.jacobian, counted.residual);
  std::vector<bool> out(readings.size(), false);
  std::vector<double> d2(readings.size());
  const auto judge = [&] {
    const Eigen::MatrixXd inverse = inverse_symmetric(normal);
    const Eigen::VectorXd residual = fit.system.residual - times(J, times(inverse, right));
    const Eigen::MatrixXd solved = product(J, inverse);
    const double variance = std::pow(spread(residual, coordinates, J.cols()), 2);
    for (std::size_t k = 0; k < readings.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      Eigen::Matrix3d expected = rows_product(J.middleRows<3>(3 * i), solved.middleRows<3>(3 * i));
      expected *= out[k] ? 1 : -fit.weights[i];
      expected.diagonal().array() += 1;
      const SymmetricEigen3 eigen = symmetric_eigen(expected);
      d2[k] = 0;
      // a reading that alone determines something is fitted whatever it says: nothing judges it
      if (eigen.values[0] < kJudged) continue;
      const Eigen::Vector3d r = residual.segment<3>(3 * i);
      for (int c = 0; c < 3; ++c) {
        d2[k] += std::pow(eigen.vectors.col(c).dot(r), 2) / (eigen.values[c] * variance);
      }
    }
  };
  const std::size_t most = readings.size() / 4;
  for (std::size_t n_out = 0;;) {
    judge();
    std::vector<std::size_t> beyond;
    for (std::size_t k = 0; k < readings.size(); ++k) {
      if (!out[k] && d2[k] > limit) beyond.push_back(k);
    }
    if (beyond.empty() || n_out == most) break;
    std::ranges::sort(beyond, [&](std::size_t a, std::size_t b) { return d2[a] > d2[b]; });
    const double least = kSetAside * d2[beyond.front()];
    for (const std::size_t k : beyond) {
      if (d2[k] < least || n_out == most) break;
      const auto i = static_cast<Eigen::Index>(k);
      const Eigen::MatrixXd rows = J.middleRows<3>(3 * i);
      add_gram(normal, rows, -fit.weights[i]);
      right -= fit.weights[i] * transposed_times(rows, fit.system.residual.segment<3>(3 * i));
      out[k] = true;
      ++n_out;
    }
  }
  std::vector<OutlyingReading> found;
  for (std::size_t k = 0; k < readings.size(); ++k) {
    if (d2[k] <= limit) continue;
    found.push_back({readings[k].seq, std::sqrt(d2[k]), fit.weights[static_cast<Eigen::Index>(k)]});
  }
  return found;
}

PredictedPose predict_with_covariance(const GeometryFit& fit, const Conditions& conditions) {
  const Prediction at = predict(fit.model, conditions);
  if (!at.ok()) {
    throw InputError({.what = "the model cannot reach the commanded displacements asked for"});
  }
  const Eigen::Matrix3Xd J = derivative(fit.model, fit.parameters, conditions, at);
  return {at.pose, rows_product(product(J, fit.covariance), J)};
}

}  // namespace trammel
