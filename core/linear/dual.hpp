#pragma once
// Dual numbers: a value and its derivatives, carried through a formula (forward differentiation).
// Nested they carry second derivatives: of what moves in time (Moving).

#include <array>
#include <cmath>
#include <cstddef>

namespace trammel {

/// f + f'.e with e_i e_j = 0. Proof: finite differences (machine_test.cpp).
template <std::size_t N, class S = double>
struct Dual {
  S v{};
  std::array<S, N> d{};

  Dual() = default;
  Dual(double value) : v(value) {}  // NOLINT: a number is a constant
  static Dual variable(double value, std::size_t k) {
    Dual x(value);
    x.d[k] = S(1.0);
    return x;
  }

  friend Dual operator+(const Dual& a, const Dual& b) {
    return from(
        a.v + b.v, a, [](const S& x) { return x; }, b, [](const S& y) { return y; });
  }
  friend Dual operator-(const Dual& a, const Dual& b) {
    return from(
        a.v - b.v, a, [](const S& x) { return x; }, b, [](const S& y) { return -y; });
  }
  friend Dual operator*(const Dual& a, const Dual& b) {
    return from(
        a.v * b.v, a, [&](const S& x) { return x * b.v; }, b, [&](const S& y) { return a.v * y; });
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    const S q = a.v / b.v;
    return from(
        q, a, [&](const S& x) { return x / b.v; }, b, [&](const S& y) { return -(q * y) / b.v; });
  }
  friend Dual operator-(const Dual& a) { return Dual() - a; }
  friend Dual sqrt(const Dual& a) {
    using std::sqrt;
    const S root = sqrt(a.v);
    return chain(a, root, S(0.5) / root);
  }
  friend Dual sin(const Dual& a) {
    using std::cos, std::sin;
    return chain(a, sin(a.v), cos(a.v));
  }
  friend Dual cos(const Dual& a) {
    using std::cos, std::sin;
    return chain(a, cos(a.v), -sin(a.v));
  }
  friend Dual atan2(const Dual& y, const Dual& x) {
    using std::atan2;
    const S square = x.v * x.v + y.v * y.v;
    return from(
        atan2(y.v, x.v), y, [&](const S& dy) { return x.v * dy / square; }, x,
        [&](const S& dx) { return -(y.v * dx) / square; });
  }

 private:
  template <class A, class B>
  static Dual from(const S& value, const Dual& a, const A& of_a, const Dual& b, const B& of_b) {
    Dual f;
    f.v = value;
    for (std::size_t k = 0; k < N; ++k) f.d[k] = of_a(a.d[k]) + of_b(b.d[k]);
    return f;
  }
  static Dual chain(const Dual& a, const S& value, const S& slope) {
    Dual f;
    f.v = value;
    for (std::size_t k = 0; k < N; ++k) f.d[k] = slope * a.d[k];
    return f;
  }
};

/// A number that moves: value, first and second derivative by time.
using Moving = Dual<1, Dual<1>>;
inline Moving moving(double x, double x_dot, double x_ddot) {
  Moving m;
  m.v.v = x;
  m.v.d[0] = m.d[0].v = x_dot;
  m.d[0].d[0] = x_ddot;
  return m;
}
inline double value_of(double x) { return x; }
inline double value_of(const Moving& x) { return x.v.v; }
inline double rate_of(const Moving& x) { return x.v.d[0]; }
inline double acceleration_of(const Moving& x) { return x.d[0].d[0]; }

}  // namespace trammel
