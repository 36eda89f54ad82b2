#include "core/calibrate/idw.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

#include "core/error.hpp"

namespace trammel {

namespace {

constexpr std::size_t kLanes = 8;       // queries side by side: the compiler vectorises over them
constexpr double kOnSampleMm2 = 1e-24;  // closer than 1e-12 mm is on the sample

/// 1 / d^power from d^2, without std::pow for the powers in use.
struct WeightSquare {
  double operator()(double d2) const { return 1.0 / d2; }
};
struct WeightEven {
  int half;
  double operator()(double d2) const {
    double product = d2;
    for (int k = 1; k < half; ++k) product *= d2;
    return 1.0 / product;
  }
};
struct WeightOdd {
  int half;  // power = 2 half + 1
  double operator()(double d2) const {
    double product = std::sqrt(d2);
    for (int k = 0; k < half; ++k) product *= d2;
    return 1.0 / product;
  }
};
struct WeightAny {
  double power;
  double operator()(double d2) const { return std::exp(-0.5 * power * std::log(d2)); }
};

template <class Run>
void with_weight(double power, const Run& run) {
  const double whole = std::round(power);
  if (power == 2) {
    run(WeightSquare{});
  } else if (power != whole || power > 16) {
    run(WeightAny{power});
  } else if (const int n = static_cast<int>(whole); n % 2 == 0) {
    run(WeightEven{n / 2});
  } else {
    run(WeightOdd{n / 2});
  }
}

Eigen::Vector3d sample(const IdwMap& map, std::size_t k) {
  return {map.e1_mm[k], map.e2_mm[k], map.e3_mm[k]};
}

double squared_distance(const IdwMap& map, std::size_t k, Place at) {
  const double dx = at.x_mm - map.x_mm[k], dy = at.y_mm - map.y_mm[k];
  return dx * dx + dy * dy;
}

Eigen::Vector3d nearest_sample(const IdwMap& map, Place at) {
  std::size_t best = 0;
  for (std::size_t k = 1; k < map.x_mm.size(); ++k) {
    if (squared_distance(map, k, at) < squared_distance(map, best, at)) best = k;
  }
  return sample(map, best);
}

/// All samples, kLanes queries at once; n <= kLanes of them count.
template <class Weight>
void predict_block(const IdwMap& map, const Weight& weight, const Place* at, std::size_t n,
                   Eigen::Vector3d* out) {
  std::array<double, kLanes> qx, qy, sum{}, s1{}, s2{}, s3{}, closest;
  closest.fill(std::numeric_limits<double>::infinity());
  for (std::size_t j = 0; j < kLanes; ++j) {
    qx[j] = at[std::min(j, n - 1)].x_mm;
    qy[j] = at[std::min(j, n - 1)].y_mm;
  }
  for (std::size_t k = 0; k < map.x_mm.size(); ++k) {
    const double x = map.x_mm[k], y = map.y_mm[k];
    const double e1 = map.e1_mm[k], e2 = map.e2_mm[k], e3 = map.e3_mm[k];
    for (std::size_t j = 0; j < kLanes; ++j) {
      const double dx = qx[j] - x, dy = qy[j] - y;
      const double d2 = dx * dx + dy * dy;
      const double w = weight(d2);
      closest[j] = d2 < closest[j] ? d2 : closest[j];
      sum[j] += w;
      s1[j] += w * e1;
      s2[j] += w * e2;
      s3[j] += w * e3;
    }
  }
  for (std::size_t j = 0; j < n; ++j) {
    out[j] = closest[j] <= kOnSampleMm2 ? nearest_sample(map, at[j])
                                        : Eigen::Vector3d(s1[j], s2[j], s3[j]) / sum[j];
  }
}

/// The nearest few only: `order` is scratch of the map's size.
template <class Weight>
Eigen::Vector3d predict_local(const IdwMap& map, const Weight& weight, Place at,
                              std::vector<std::size_t>& order) {
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto closer = [&](std::size_t a, std::size_t b) {
    const double da = squared_distance(map, a, at), db = squared_distance(map, b, at);
    return da < db || (da == db && a < b);
  };
  const auto last = order.begin() + map.options.neighbours;
  std::partial_sort(order.begin(), last, order.end(), closer);
  if (squared_distance(map, order[0], at) <= kOnSampleMm2) return sample(map, order[0]);
  double sum = 0;
  Eigen::Vector3d total = Eigen::Vector3d::Zero();
  for (auto k = order.begin(); k != last; ++k) {
    const double w = weight(squared_distance(map, *k, at));
    sum += w;
    total += w * sample(map, *k);
  }
  return total / sum;
}

void require_options(const IdwOptions& options, std::size_t places) {
  if (!(std::isfinite(options.power) && options.power > 0)) {
    throw InputError({.what = "the weights of IDW need a positive power",
                      .where = {.field = "power"},
                      .got = std::to_string(options.power),
                      .expected = "a positive number (the paper: 2)"});
  }
  if (options.neighbours < 0 || static_cast<std::size_t>(options.neighbours) > places) {
    throw InputError({.what = "IDW cannot use that many neighbours",
                      .where = {.field = "neighbours"},
                      .got = std::to_string(options.neighbours),
                      .expected = "1 to " + std::to_string(places) + ", or 0 for all"});
  }
}

}  // namespace

IdwMap fit_idw(std::span<const JointSample> samples, const IdwOptions& options) {
  require_places(samples, 1);
  const std::vector<JointSample> places = merge_places(samples);
  require_options(options, places.size());
  IdwMap map{.options = options, .x_mm = {}, .y_mm = {}, .e1_mm = {}, .e2_mm = {}, .e3_mm = {}};
  for (const JointSample& s : places) {
    map.x_mm.push_back(s.x_mm);
    map.y_mm.push_back(s.y_mm);
    map.e1_mm.push_back(s.error_mm[0]);
    map.e2_mm.push_back(s.error_mm[1]);
    map.e3_mm.push_back(s.error_mm[2]);
  }
  return map;
}

void predict(const IdwMap& map, std::span<const Place> at, std::span<Eigen::Vector3d> errors_mm) {
  TRAMMEL_ASSERT(at.size() == errors_mm.size());
  with_weight(map.options.power, [&](const auto& weight) {
    if (map.options.neighbours > 0) {
      std::vector<std::size_t> order(map.x_mm.size());
      for (std::size_t q = 0; q < at.size(); ++q) {
        errors_mm[q] = predict_local(map, weight, at[q], order);
      }
      return;
    }
    for (std::size_t q = 0; q < at.size(); q += kLanes) {
      predict_block(map, weight, &at[q], std::min(kLanes, at.size() - q), &errors_mm[q]);
    }
  });
}

IdwOptions tune_idw(std::span<const JointSample> samples) {
  require_places(samples, 5);
  const std::vector<JointSample> places = merge_places(samples);
  IdwOptions best;
  double least = std::numeric_limits<double>::infinity();
  for (const int neighbours : {4, 6, 8, 12, 16, 24, 0}) {
    if (static_cast<std::size_t>(neighbours) + 1 > places.size()) continue;
    for (const double power : {1.0, 2.0, 3.0, 4.0}) {
      double sum = 0;
      for (std::size_t out = 0; out < places.size(); ++out) {
        std::vector<JointSample> others = places;
        others.erase(others.begin() + static_cast<std::ptrdiff_t>(out));
        const IdwMap map = fit_idw(others, {.power = power, .neighbours = neighbours});
        const JointSample& s = places[out];
        sum += (predict(map, Place{s.x_mm, s.y_mm}) - s.error_mm).squaredNorm();
      }
      if (sum >= least) continue;
      least = sum;
      best = {.power = power, .neighbours = neighbours};
    }
  }
  return best;
}

Eigen::Vector3d predict(const IdwMap& map, Place at) {
  Eigen::Vector3d error;
  predict(map, {&at, 1}, {&error, 1});
  return error;
}

}  // namespace trammel
