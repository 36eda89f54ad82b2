#include "core/linear/lanes.hpp"

#include <array>
#include <vector>

#include "core/statistics/random.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/cpu_levels.hpp"

using namespace trammel;

namespace {

constexpr double kUlp = 2.3e-16;  // half a unit of the argument's rounding is in it

/// `f` of all x, on one level of CPU.
template <class F>
std::vector<double> mapped(const std::vector<double>& x, CpuLevel level, const F& f) {
  std::vector<double> y(x.size());
  at_level(level, [&]<int n>() {
    in_blocks<n>(std::span(x), std::span(y), [&](const double* in, double* out) {
      Real<n> lanes;
      for (int j = 0; j < n; ++j) lanes[j] = in[j];
      lanes = f.template operator()<n>(lanes);
      for (int j = 0; j < n; ++j) out[j] = lanes[j];
    });
  });
  return y;
}

constexpr auto kExp2 = []<int n>(const Real<n>& t) { return exp2_of_negative<n>(t); };
constexpr auto kSine = []<int n>(const Real<n>& x) { return sine_cosine_of<n>(x).sine; };
constexpr auto kCosine = []<int n>(const Real<n>& x) { return sine_cosine_of<n>(x).cosine; };

std::vector<double> drawn(double low, double high) {
  Random random(31);
  std::vector<double> x = {low, high};
  for (int k = 0; k < 20'001; ++k) x.push_back(random.uniform(low, high));
  return x;
}

}  // namespace

TEST_CASE("2^t of lanes is within an ulp of the library's, and does not fall below 2^-1000",
          "[core]") {
  const std::vector<double> t = drawn(-999, 0);
  const std::vector<double> y = mapped(t, cpu_level(), kExp2);
  for (std::size_t k = 0; k < t.size(); ++k) {
    if (!(std::abs(y[k] / std::exp2(t[k]) - 1) < kUlp)) FAIL(t[k]);
  }
  CHECK(mapped({0.0}, cpu_level(), kExp2)[0] == 1.0);
  CHECK(mapped({-1e300}, cpu_level(), kExp2)[0] == std::exp2(-1000.0));
}

TEST_CASE("sine and cosine of lanes are within an ulp of one of the library's", "[core]") {
  for (const double range : {0.8, 7.0, kLargestAngle}) {
    const std::vector<double> x = drawn(-range, range);
    const auto sine = mapped(x, cpu_level(), kSine), cosine = mapped(x, cpu_level(), kCosine);
    for (std::size_t k = 0; k < x.size(); ++k) {
      if (!(std::abs(sine[k] - std::sin(x[k])) < kUlp)) FAIL(x[k]);
      if (!(std::abs(cosine[k] - std::cos(x[k])) < kUlp)) FAIL(x[k]);
    }
  }
}

TEST_CASE("functions of lanes give the same bits on every level of CPU", "[core]") {
  const std::vector<double> t = drawn(-1100, 0), x = drawn(-50, 50);
  for (const CpuLevel level : tests::levels_here()) {
    INFO(name_of(level));
    CHECK(mapped(t, level, kExp2) == mapped(t, CpuLevel::x86_64, kExp2));
    CHECK(mapped(x, level, kSine) == mapped(x, CpuLevel::x86_64, kSine));
    CHECK(mapped(x, level, kCosine) == mapped(x, CpuLevel::x86_64, kCosine));
  }
}

TEST_CASE("triples become columns and come back, on every level of CPU", "[core]") {
  for (const CpuLevel level : tests::levels_here()) {
    INFO(name_of(level));
    at_level(level, []<int n>() {
      std::array<double, std::size_t{3} * n> triples, back;
      for (std::size_t k = 0; k < triples.size(); ++k) triples[k] = static_cast<double>(k);
      const auto columns = columns_of<n>(triples.data());
      bool right = true;
      for (int c = 0; c < 3; ++c) {
        for (int j = 0; j < n; ++j) right &= columns[static_cast<std::size_t>(c)][j] == 3 * j + c;
      }
      CHECK(right);
      store_columns<n>(columns, back.data());
      CHECK(back == triples);
    });
  }
}
