#pragma once
// From a kind's formulas, templates over the number, to its row of functions. For chain_*.cpp.

#include "core/mechanism/chain_kind.hpp"

namespace trammel {

/// The platform's joint C = (x, y) + r (cos, sin)(beta + phi).
template <class T>
std::array<T, 2> platform_joint(const T& r, const T& beta, const std::array<T, 3>& X) {
  using std::cos, std::sin;
  return {X[0] + r * cos(beta + X[2]), X[1] + r * sin(beta + X[2])};
}

template <class T>
T length_of(const T& x, const T& y) {
  using std::sqrt;
  return sqrt(x * x + y * y);
}

/// Formula: `closure<T>(p, q, X)`, T and p an array of T as long as `parameters`.
template <class Formula>
ClosureRow closure_by_duals(const ChainValues& p, double q_mm, const Pose& X) {
  constexpr std::size_t kParameters = Formula::parameters.size();
  using T = Dual<4 + kParameters>;
  std::array<T, kParameters> parameters;
  for (std::size_t k = 0; k < kParameters; ++k) parameters[k] = T::variable(p[k], 4 + k);
  const std::array<T, 3> pose = {T::variable(X.x_mm, 0), T::variable(X.y_mm, 1),
                                 T::variable(X.phi_rad, 2)};
  const T f = Formula::closure(parameters, T::variable(q_mm, 3), pose);
  ClosureRow row{.f = f.v, .f_q = f.d[3], .f_X = {f.d[0], f.d[1], f.d[2]}};
  for (std::size_t k = 0; k < kParameters; ++k) row.f_p[k] = f.d[4 + k];
  return row;
}

template <class Formula>
constexpr ChainKind kind_by(std::string_view name) {
  return {.name = name,
          .parameters = Formula::parameters,
          .closure = closure_by_duals<Formula>,
          .drive = Formula::drive,
          .fault = Formula::fault,
          .drive_word = Formula::drive_word,
          .zero = Formula::zero,
          .offset = Formula::offset,
          .on_guide = Formula::on_guide,
          .second_order = Formula::second_order};
}

}  // namespace trammel
