#include "core/calibrate/idw.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

#include "core/error.hpp"
#include "core/linear/lanes.hpp"

namespace trammel {

namespace {

constexpr double kOnSampleMm2 = 1e-24;  // closer than 1e-12 mm is on the sample

/// 1 / d^power from d^2, of one number or of lanes, without std::pow for the powers in use.
struct WeightSquare {
  template <class T>
  T operator()(const T& d2) const {
    return 1.0 / d2;
  }
};
struct WeightEven {
  int half;
  template <class T>
  T operator()(const T& d2) const {
    T product = d2;
    for (int k = 1; k < half; ++k) product *= d2;
    return 1.0 / product;
  }
};
struct WeightOdd {
  int half;  // power = 2 half + 1
  template <class T>
  T operator()(const T& d2) const {
    T product = each(d2, [](double x) { return std::sqrt(x); });
    for (int k = 0; k < half; ++k) product *= d2;
    return 1.0 / product;
  }
};
struct WeightAny {
  double power;
  template <class T>
  T operator()(const T& d2) const {
    return each(d2, [this](double x) { return std::exp(-0.5 * power * std::log(x)); });
  }
};

/// The weights of two samples. Division is what a block waits for, and two can share one:
///   1 / a = b / (a b),   1 / b = a / (a b).
/// Not for higher powers, whose product may leave a double's range where the weights do not.
template <class T>
struct Weights {
  T first, second;
};
template <class Weight, class T>
Weights<T> weigh_two(const Weight& weigh, const T& a, const T& b) {
  return {weigh(a), weigh(b)};
}
template <class T>
Weights<T> weigh_two(const WeightSquare& weigh, const T& a, const T& b) {
  const T both = weigh(T(a * b));
  return {b * both, a * both};
}

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

std::size_t nearest(const IdwMap& map, Place at) {
  std::size_t best = 0;
  for (std::size_t k = 1; k < map.x_mm.size(); ++k) {
    if (squared_distance(map, k, at) < squared_distance(map, best, at)) best = k;
  }
  return best;
}

/// The plain sum of one query, for those that the blocks cannot weigh.
template <class Weight>
Eigen::Vector3d predict_alone(const IdwMap& map, const Weight& weigh, Place at) {
  const std::size_t closest = nearest(map, at);
  if (squared_distance(map, closest, at) <= kOnSampleMm2) return sample(map, closest);
  double sum = 0;
  Eigen::Vector3d total = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < map.x_mm.size(); ++k) {
    const double w = weigh(squared_distance(map, k, at));
    sum += w;
    total += w * sample(map, k);
  }
  return total / sum;
}

/// All samples, n queries side by side.
template <int n, class Weight>
void predict_block(const IdwMap& map, const Weight& weigh, const Place* at, Eigen::Vector3d* out) {
  Real<n> x, y, w = {}, e1 = {}, e2 = {}, e3 = {};
  for (std::size_t j = 0; j < n; ++j) {
    x[j] = at[j].x_mm;
    y[j] = at[j].y_mm;
  }
  const auto distance = [&](std::size_t k) {
    const Real<n> dx = x - map.x_mm[k], dy = y - map.y_mm[k];
    return Real<n>(dx * dx + dy * dy);
  };
  const auto add = [&](std::size_t k, const Real<n>& weight) {
    w += weight;
    e1 += weight * map.e1_mm[k];
    e2 += weight * map.e2_mm[k];
    e3 += weight * map.e3_mm[k];
  };
  const std::size_t paired = map.x_mm.size() - map.x_mm.size() % 2;
  for (std::size_t k = 0; k < paired; k += 2) {
    const Weights<Real<n>> two = weigh_two(weigh, distance(k), distance(k + 1));
    add(k, two.first);
    add(k + 1, two.second);
  }
  if (paired < map.x_mm.size()) add(paired, weigh(distance(paired)));
  e1 /= w;
  e2 /= w;
  e3 /= w;
  const double on_sample = weigh(kOnSampleMm2);
  for (std::size_t j = 0; j < n; ++j) {
    // on a sample, or out of a double's range: not less, or not a number
    out[j] = w[j] < on_sample && w[j] > 0 ? Eigen::Vector3d(e1[j], e2[j], e3[j])
                                          : predict_alone(map, weigh, at[j]);
  }
}

/// The nearest few only: `order` is scratch of the map's size.
template <class Weight>
Eigen::Vector3d predict_local(const IdwMap& map, const Weight& weigh, Place at,
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
    const double w = weigh(squared_distance(map, *k, at));
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

void predict(const IdwMap& map, std::span<const Place> at, std::span<Eigen::Vector3d> errors_mm,
             CpuLevel level) {
  TRAMMEL_ASSERT(at.size() == errors_mm.size());
  with_weight(map.options.power, [&](const auto& weigh) {
    if (map.options.neighbours > 0) {
      std::vector<std::size_t> order(map.x_mm.size());
      for (std::size_t q = 0; q < at.size(); ++q) {
        errors_mm[q] = predict_local(map, weigh, at[q], order);
      }
      return;
    }
    at_level(level, [&]<int n>() {
      in_blocks<n>(at, errors_mm, [&](const Place* from, Eigen::Vector3d* to) {
        predict_block<n>(map, weigh, from, to);
      });
    });
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
