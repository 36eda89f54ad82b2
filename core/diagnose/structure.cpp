#include "core/diagnose/structure.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <thread>

#include "core/statistics/random.hpp"

namespace trammel {

namespace {

/// A quadratic form r' W r that is large when neighbours agree.
struct Neighbours {
  std::string where, when;
  std::vector<std::pair<int, int>> pairs;  // of readings
};

Neighbours in_time(const ResidualSpace& space) {
  Neighbours n{"readings", kSuccessiveAgree, {}};
  for (std::size_t i = 0; i + 1 < space.readings.size(); ++i) {
    if (space.readings[i].conditions.epoch == space.readings[i + 1].conditions.epoch) {
      n.pairs.emplace_back(static_cast<int>(i), static_cast<int>(i + 1));
    }
  }
  return n;
}

Neighbours in_space(const ResidualSpace& space) {
  constexpr std::size_t kNearest = 4;
  Neighbours n{"readings", "readings at neighbouring poses agree", {}};
  const std::size_t count = space.readings.size();
  std::vector<std::pair<double, int>> distance(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Pose& a = space.readings[i].target;
    for (std::size_t j = 0; j < count; ++j) {
      const Pose& b = space.readings[j].target;
      const double dx = a.x_mm - b.x_mm, dy = a.y_mm - b.y_mm;
      distance[j] = {i == j ? INFINITY : dx * dx + dy * dy, static_cast<int>(j)};
    }
    const std::size_t k = std::min(kNearest, count - 1);
    std::partial_sort(distance.begin(), distance.begin() + static_cast<std::ptrdiff_t>(k),
                      distance.end());
    for (std::size_t j = 0; j < k; ++j)
      n.pairs.emplace_back(static_cast<int>(i), distance[j].second);
  }
  return n;
}

/// Mean product of neighbouring residuals over their mean square, for each column of `r`.
Eigen::VectorXd agreement(const Neighbours& neighbours, const Eigen::MatrixXd& r) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(r.cols());
  for (Eigen::Index c = 0; c < r.cols(); ++c) {
    double products = 0;
    for (const auto& [i, j] : neighbours.pairs) {
      const double* a = &r(3 * i, c);
      const double* b = &r(3 * j, c);
      products += a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    }
    sum[c] = products / r.col(c).squaredNorm();
  }
  return sum;
}

struct Battery {
  std::vector<Eigen::MatrixXd> bases;  // one a shape that survives
  std::vector<const Shape*> shapes;
  Eigen::MatrixXd all;  // the bases side by side
  std::vector<Neighbours> neighbours;
  Eigen::VectorXd agreement_mean, agreement_std;  // from the bootstrap
  int dof = 0;
};

Battery make_battery(const ResidualSpace& space, const std::vector<Shape>& shapes) {
  Battery battery;
  battery.dof = space.dof();
  Eigen::Index columns = 0;
  for (const Shape& shape : shapes) {
    const Eigen::MatrixXd projected = space.project(shape.columns);
    if (projected.norm() < 1e-6 * shape.columns.norm()) continue;  // the base imitates it
    battery.bases.push_back(orthonormal(projected));
    battery.shapes.push_back(&shape);
    columns += battery.bases.back().cols();
  }
  battery.all.resize(space.rows(), columns);
  Eigen::Index at = 0;
  for (const auto& basis : battery.bases) {
    battery.all.middleCols(at, basis.cols()) = basis;
    at += basis.cols();
  }
  if (space.readings.size() > 8) battery.neighbours = {in_time(space), in_space(space)};
  return battery;
}

/// p of every test, shapes first, for residuals in the columns of `r` (projected already).
Eigen::MatrixXd all_p(const Battery& battery, const Eigen::MatrixXd& r) {
  const Eigen::MatrixXd coefficients = wide_transposed_product(battery.all, r);
  const auto tests = static_cast<Eigen::Index>(battery.bases.size() + battery.neighbours.size());
  Eigen::MatrixXd p(tests, r.cols());
  for (Eigen::Index c = 0; c < r.cols(); ++c) {
    const double rss = r.col(c).squaredNorm();
    Eigen::Index at = 0;
    for (std::size_t s = 0; s < battery.bases.size(); ++s) {
      const Eigen::Index k = battery.bases[s].cols();
      const double q = coefficients.col(c).segment(at, k).squaredNorm();
      const double s2 = (rss - q) / (battery.dof - static_cast<double>(k));
      p(static_cast<Eigen::Index>(s), c) = chi2_tail(q / s2, static_cast<double>(k));
      at += k;
    }
  }
  for (std::size_t n = 0; n < battery.neighbours.size(); ++n) {
    const auto row = static_cast<Eigen::Index>(battery.bases.size() + n);
    const auto i = static_cast<Eigen::Index>(n);
    const Eigen::VectorXd z =
        (agreement(battery.neighbours[n], r).array() - battery.agreement_mean[i]) /
        battery.agreement_std[i];
    for (Eigen::Index c = 0; c < r.cols(); ++c)
      p(row, c) = std::erfc(std::abs(z[c]) / std::sqrt(2.0));
  }
  return p;
}

/// The readings' residuals in another order, each with a random sign; what the refit took of a
/// reading is given back by 1 / sqrt(1 - leverage).
Eigen::MatrixXd exchanged_through_refit(const ResidualSpace& space, std::uint64_t seed, int first,
                                        int count) {
  const auto n = static_cast<Eigen::Index>(space.readings.size());
  Eigen::VectorXd pool = space.residual;
  for (Eigen::Index i = 0; i < pool.size(); ++i) {
    pool[i] /= std::sqrt(std::max(0.05, 1 - space.Q.row(i).squaredNorm()));
  }
  Eigen::MatrixXd noise(space.rows(), count);
  std::vector<Eigen::Index> order(space.readings.size());
  for (int c = 0; c < count; ++c) {
    Random random = Random::stream(seed, "exchange", static_cast<std::uint64_t>(first + c));
    std::iota(order.begin(), order.end(), Eigen::Index{0});
    for (Eigen::Index i = n; i-- > 1;) {
      const auto j = static_cast<std::size_t>(random.below(static_cast<std::uint64_t>(i + 1)));
      std::swap(order[static_cast<std::size_t>(i)], order[j]);
    }
    for (Eigen::Index i = 0; i < n; ++i) {
      const double sign = random.below(2) == 0 ? 1 : -1;
      noise.col(c).segment<3>(3 * i) =
          sign * pool.segment<3>(3 * order[static_cast<std::size_t>(i)]);
    }
  }
  return space.project(noise);
}

Eigen::MatrixXd noise_through_refit(const ResidualSpace& space, std::uint64_t seed, int first,
                                    int count) {
  Eigen::MatrixXd noise(space.rows(), count);
  for (int c = 0; c < count; ++c) {
    Random random = Random::stream(seed, "structure", static_cast<std::uint64_t>(first + c));
    for (Eigen::Index i = 0; i < noise.rows(); ++i) {
      noise(i, c) = space.is_measured(i) ? random.normal() : 0;
    }
  }
  return space.project(noise);
}

/// Runs f(block) for blocks 0..n-1 on `threads` threads; each block writes its own results.
template <typename F>
void in_parallel(int blocks, int threads, F f) {
  std::vector<std::thread> pool;
  for (int t = 1; t < threads; ++t) {
    pool.emplace_back([=] {
      for (int b = t; b < blocks; b += threads) f(b);
    });
  }
  for (int b = 0; b < blocks; b += std::max(1, threads)) f(b);
  for (auto& thread : pool) thread.join();
}

constexpr int kBlock = 100;
constexpr double kSureBound = 1e-4;
constexpr int kLargeDof = 200;  // on fewer the tail of F is far above that of chi^2

void calibrate_agreement(Battery& battery, const ResidualSpace& space, std::uint64_t seed) {
  const Eigen::MatrixXd noise = noise_through_refit(space, seed, 0, 4 * kBlock);
  const auto n = static_cast<Eigen::Index>(battery.neighbours.size());
  battery.agreement_mean.resize(n);
  battery.agreement_std.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::VectorXd a = agreement(battery.neighbours[static_cast<std::size_t>(i)], noise);
    battery.agreement_mean[i] = a.mean();
    battery.agreement_std[i] =
        std::sqrt((a.array() - a.mean()).square().sum() / static_cast<double>(a.size() - 1));
  }
}

}  // namespace

StructureTest test_structure(const ResidualSpace& space, const std::vector<Shape>& shapes,
                             const StructureOptions& options) {
  StructureTest result;
  Battery battery = make_battery(space, shapes);
  calibrate_agreement(battery, space, options.seed);
  const Eigen::VectorXd p = all_p(battery, space.residual);
  result.tests = static_cast<int>(p.size());
  if (p.size() == 0) return result;

  const double smallest_p = p.minCoeff();
  const double bound = smallest_p * static_cast<double>(p.size());
  const int wanted = smallest_p > options.level ? options.replicates / 10 : options.replicates;
  const bool sure = bound < kSureBound && battery.dof > kLargeDof && !options.exchange;
  const int blocks = sure ? 0 : (wanted + kBlock - 1) / kBlock;
  std::vector<Eigen::VectorXd> smallest(static_cast<std::size_t>(blocks));
  in_parallel(blocks, options.threads, [&](int b) {
    const Eigen::MatrixXd noise =
        options.exchange ? exchanged_through_refit(space, options.seed, b * kBlock, kBlock)
                         : noise_through_refit(space, options.seed, (b + 4) * kBlock, kBlock);
    smallest[static_cast<std::size_t>(b)] = all_p(battery, noise).colwise().minCoeff();
  });
  int as_small = 0;
  for (const auto& block : smallest) {
    as_small += static_cast<int>((block.array() <= smallest_p).count());
  }
  result.family_p = blocks == 0 ? bound : (as_small + 1.0) / (blocks * kBlock + 1.0);

  for (std::size_t s = 0; s < battery.shapes.size(); ++s) {
    const Shape& shape = *battery.shapes[s];
    result.findings.push_back({shape.where, shape.when, p[static_cast<Eigen::Index>(s)],
                               transposed_times(battery.bases[s], space.residual).squaredNorm(),
                               static_cast<int>(battery.bases[s].cols())});
  }
  for (std::size_t n = 0; n < battery.neighbours.size(); ++n) {
    const Neighbours& pairs = battery.neighbours[n];
    const bool alternate =
        pairs.when == kSuccessiveAgree &&
        agreement(pairs, space.residual)[0] < battery.agreement_mean[static_cast<Eigen::Index>(n)];
    result.findings.push_back({pairs.where, alternate ? kSuccessiveAlternate : pairs.when,
                               p[static_cast<Eigen::Index>(battery.bases.size() + n)], 0, 1});
  }
  std::stable_sort(result.findings.begin(), result.findings.end(),
                   [](const Finding& a, const Finding& b) { return a.p < b.p; });
  return result;
}

double successive_agreement(const ResidualSpace& space, const std::vector<Shape>& removed) {
  Eigen::Index columns = space.Q.cols();
  for (const Shape& shape : removed) columns += shape.columns.cols();
  Eigen::MatrixXd all(space.rows(), columns);
  all.leftCols(space.Q.cols()) = space.Q;
  Eigen::Index at = space.Q.cols();
  for (const Shape& shape : removed) {
    all.middleCols(at, shape.columns.cols()) = shape.columns;
    at += shape.columns.cols();
  }
  for (Eigen::Index j = 0; j < columns; ++j) all.col(j).normalize();
  ResidualSpace left = space;
  left.Q = orthonormal(all);
  left.residual = left.project(space.residual);
  Battery battery;
  battery.neighbours = {in_time(space)};
  calibrate_agreement(battery, left, 1);
  return (agreement(battery.neighbours[0], left.residual)[0] - battery.agreement_mean[0]) /
         battery.agreement_std[0];
}

}  // namespace trammel
