// RPR: a driven cylinder from a joint A of the base to the platform's joint C.

#include "core/mechanism/chain_formula.hpp"

namespace trammel {

namespace {

///   f = |C - A| - (q + l)
struct Rpr {
  static constexpr std::string_view drive_word = "cylinder";
  static constexpr std::size_t zero = 2;
  static constexpr std::optional<std::size_t> offset = {};
  static constexpr OnGuide (*on_guide)(const ChainValues&, double, const Pose&) = nullptr;
  static constexpr bool (*second_order)(const ChainValues&, std::size_t) = nullptr;
  static constexpr std::array<ChainParameter, 5> parameters = {{
      {.symbol = "Ax", .field = "Ax_mm"},
      {.symbol = "Ay", .field = "Ay_mm"},
      {.symbol = "l", .field = "l_zero_mm", .optional = true},
      {.symbol = "r", .field = "r_mm", .range = ValueRange::positive, .platform = true},
      {.symbol = "beta", .field = "beta_deg", .platform = true},
  }};

  template <class T>
  static T closure(const std::array<T, 5>& p, const T& q, const std::array<T, 3>& X) {
    const auto& [Ax, Ay, l, r, beta] = p;
    const std::array<T, 2> C = platform_joint(r, beta, X);
    return length_of(C[0] - Ax, C[1] - Ay) - (q + l);
  }

  ///   q = |C - A| - l; at C = A no direction is defined
  static std::optional<ChainMotion> drive(const ChainValues& p, const MovingPose& X) {
    const double Ax = p[0], Ay = p[1], l = p[2];
    const std::array<Moving, 2> C = platform_joint<Moving>(p[3], p[4], X);
    const Moving x = C[0] - Ax, y = C[1] - Ay, length = length_of(x, y);
    if (!(value_of(length) > 0)) return {};
    return ChainMotion{length - l, atan2(y, x)};
  }

  static std::optional<std::string_view> fault(const ChainValues&) { return {}; }
};

}  // namespace

constinit const ChainKind kRprChain = kind_by<Rpr>("RPR");

}  // namespace trammel
