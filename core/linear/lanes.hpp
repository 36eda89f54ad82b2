#pragma once
// Numbers side by side, for kernels of cpu_level.hpp, and the functions of them that the kernels
// need: + - * / and the square root alone, so that every level gives the same bits.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>

namespace trammel {

template <int n>
struct LaneTypes {
  typedef double Real __attribute__((vector_size(8 * n)));
  typedef std::int64_t Whole __attribute__((vector_size(8 * n)));
};
/// n numbers. + - * / and comparisons go lane by lane; `mask ? a : b` chooses lane by lane.
template <int n>
using Real = typename LaneTypes<n>::Real;
template <int n>
using Whole = typename LaneTypes<n>::Whole;

/// From n numbers that stand anywhere, and back.
template <int n>
Real<n> load_lanes(const double* from) {
  Real<n> v;
  std::memcpy(&v, from, sizeof v);
  return v;
}
template <int n>
void store_lanes(const Real<n>& v, double* to) {
  std::memcpy(to, &v, sizeof v);
}

/// `f` of every lane, and of one number.
template <class F>
double each(double x, const F& f) {
  return f(x);
}
template <class T, class F>
T each(const T& x, const F& f) {
  T y;
  for (unsigned j = 0; j < sizeof(T) / sizeof(double); ++j) y[j] = f(x[j]);
  return y;
}

/// Sums keep eight partial ones on every level of CPU, so that the bits are the same on each.
inline constexpr int kPartialSums = 8;
using PartialSums = Real<kPartialSums>;
inline double total(const PartialSums& v) {
  return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7]));
}

/// Gives `block(in, out)` n inputs and places for n outputs at a time; the last ones are filled up
/// with copies whose outputs are dropped.
template <int n, class In, class Out, class Block>
void in_blocks(std::span<const In> in, std::span<Out> out, const Block& block) {
  const std::size_t whole = in.size() - in.size() % n;
  for (std::size_t k = 0; k < whole; k += n) block(&in[k], &out[k]);
  if (whole == in.size()) return;
  constexpr auto kSize = static_cast<std::size_t>(n);
  std::array<In, kSize> last_in;
  std::array<Out, kSize> last_out;
  last_in.fill(in.back());
  std::copy(in.begin() + static_cast<std::ptrdiff_t>(whole), in.end(), last_in.begin());
  block(last_in.data(), last_out.data());
  std::copy_n(last_out.begin(), in.size() - whole,
              out.begin() + static_cast<std::ptrdiff_t>(whole));
}

/// Triples that stand one after the other, as n first, n second and n third numbers, and back:
///   columns[c][j] = triples[3 j + c].
template <int n>
std::array<Real<n>, 3> columns_of(const void* triples) {
  std::array<Real<n>, 3> in, columns;
  std::memcpy(in.data(), triples, sizeof in);
  const auto column = [&]<int c, int... j>(std::integral_constant<int, c>,
                                           std::integer_sequence<int, j...>) {
    // of the first two thirds what is there, then of the last one
    const Real<n> most =
        __builtin_shufflevector(in[0], in[1], (3 * j + c < 2 * n ? 3 * j + c : 0)...);
    return __builtin_shufflevector(most, in[2], (3 * j + c < 2 * n ? j : 3 * j + c - n)...);
  };
  constexpr auto kEach = std::make_integer_sequence<int, n>{};
  columns[0] = column(std::integral_constant<int, 0>{}, kEach);
  columns[1] = column(std::integral_constant<int, 1>{}, kEach);
  columns[2] = column(std::integral_constant<int, 2>{}, kEach);
  return columns;
}
template <int n>
void store_columns(const std::array<Real<n>, 3>& columns, void* triples) {
  std::array<Real<n>, 3> out;
  const auto third = [&]<int t, int... j>(std::integral_constant<int, t>,
                                          std::integer_sequence<int, j...>) {
    const Real<n> two = __builtin_shufflevector(
        columns[0], columns[1], ((n * t + j) % 3 == 1 ? n + (n * t + j) / 3 : (n * t + j) / 3)...);
    return __builtin_shufflevector(two, columns[2],
                                   ((n * t + j) % 3 == 2 ? n + (n * t + j) / 3 : j)...);
  };
  constexpr auto kEach = std::make_integer_sequence<int, n>{};
  out[0] = third(std::integral_constant<int, 0>{}, kEach);
  out[1] = third(std::integral_constant<int, 1>{}, kEach);
  out[2] = third(std::integral_constant<int, 2>{}, kEach);
  std::memcpy(triples, out.data(), sizeof out);
}

/// A sum with this rounds to a whole number, which then stands in its lowest bits.
inline constexpr double kRoundToWhole = 6755399441055744.0;  // 1.5 * 2^52

/// 2^t for t <= 0; below 2^-1000 it stays there.
///   2^t = 2^i (1 + 2 x P(x^2) / (Q(x^2) - x P(x^2))),   t = i + x,   |x| <= 1/2
/// Source: Moshier, Cephes (exp2.c). Within 2.3e-16 of the value (lanes_test.cpp).
template <int n>
Real<n> exp2_of_negative(const Real<n>& t) {
  const Real<n> kept = t < -1000.0 ? Real<n>{} - 1000.0 : t;
  const Real<n> shifted = kept + kRoundToWhole;
  const Real<n> x = kept - (shifted - kRoundToWhole);
  const Real<n> z = x * x;
  const Real<n> P =
      ((2.30933477057345225087e-2 * z + 2.02020656693165307700e1) * z + 1.51390680115615096133e3) *
      x;
  const Real<n> Q = (z + 2.33184211722314911771e2) * z + 4.36821166879210612817e3;
  const Real<n> fraction = 1.0 + 2.0 * (P / (Q - P));
  // i is added to the exponent
  return reinterpret_cast<Real<n>>(reinterpret_cast<Whole<n>>(fraction) +
                                   (reinterpret_cast<Whole<n>>(shifted) << 52));
}

template <int n>
struct SineCosine {
  Real<n> sine, cosine;
};

/// Sine and cosine of |x| <= kLargestAngle, by the quarter turn nearest to x and polynomials on the
/// rest. Source: Moshier, Cephes (sin.c). Within 2.3e-16 of the value (lanes_test.cpp).
inline constexpr double kLargestAngle = 1e4;
template <int n>
SineCosine<n> sine_cosine_of(const Real<n>& x) {
  const Real<n> shifted = x * 0.63661977236758134308 + kRoundToWhole;  // 2 / pi
  const Real<n> quarters = shifted - kRoundToWhole;
  const Real<n> r =
      ((x - quarters * 1.57079625129699707031) - quarters * 7.54978941586159635335e-8) -
      quarters * 5.39030285815811905290e-15;  // pi / 2 in three parts
  const Real<n> z = r * r;
  const Real<n> s = r + r * z *
                            (((((1.58962301576546568060e-10 * z - 2.50507477628578072866e-8) * z +
                                2.75573136213857245213e-6) *
                                   z -
                               1.98412698295895385996e-4) *
                                  z +
                              8.33333333332211858878e-3) *
                                 z -
                             1.66666666666666307295e-1);
  const Real<n> c = 1.0 - 0.5 * z +
                    z * z *
                        (((((-1.13585365213876817300e-11 * z + 2.08757008419747316778e-9) * z -
                            2.75573141792967388112e-7) *
                               z +
                           2.48015872888517045348e-5) *
                              z -
                          1.38888888888730564116e-3) *
                             z +
                         4.16666666666665929218e-2);
  const Whole<n> quadrant = reinterpret_cast<Whole<n>>(shifted);
  // bit by bit, since the baseline cannot compare whole numbers: all bits of `odd`, or none
  const Whole<n> odd = -(quadrant & 1), sines = reinterpret_cast<Whole<n>>(s),
                 cosines = reinterpret_cast<Whole<n>>(c);
  const Whole<n> sine_sign = (quadrant & 2) << 62, cosine_sign = ((quadrant + 1) & 2) << 62;
  return {reinterpret_cast<Real<n>>(((cosines & odd) | (sines & ~odd)) ^ sine_sign),
          reinterpret_cast<Real<n>>(((sines & odd) | (cosines & ~odd)) ^ cosine_sign)};
}

}  // namespace trammel
