// PRR: a driven slider B on a rail, a link of length S from B to the platform's joint C.

#include "core/mechanism/chain_formula.hpp"

namespace trammel {

namespace {

///   f = |C - B| - S,   B = (q + l - R) u + h n,   u = (cos, sin)(alpha),  n = (-sin, cos)(alpha)
struct Prr {
  static constexpr std::string_view drive_word = "rail";
  static constexpr std::size_t zero = 4;
  static constexpr std::optional<std::size_t> offset = 6;
  static constexpr OnGuide (*on_guide)(const ChainValues&, double, const Pose&) = nullptr;
  static constexpr bool (*second_order)(const ChainValues&, std::size_t) = nullptr;
  static constexpr std::array<ChainParameter, 7> parameters = {{
      {.symbol = "alpha", .field = "alpha_deg"},
      {.symbol = "beta", .field = "beta_deg", .platform = true},
      {.symbol = "r", .field = "r_mm", .range = ValueRange::positive, .platform = true},
      {.symbol = "S", .field = "S_mm", .range = ValueRange::positive},
      {.symbol = "l", .field = "l_zero_mm", .optional = true},
      {.symbol = "R", .field = "R_mm", .range = ValueRange::positive},
      {.symbol = "h", .field = "h_mm", .optional = true, .completes = true},
  }};

  template <class T>
  static T closure(const std::array<T, 7>& p, const T& q, const std::array<T, 3>& X) {
    using std::cos, std::sin;
    const auto& [alpha, beta, r, S, l, R, h] = p;
    const std::array<T, 2> C = platform_joint(r, beta, X);
    const T ca = cos(alpha), sa = sin(alpha), s = q + l - R;
    return length_of(C[0] - (s * ca - h * sa), C[1] - (s * sa + h * ca)) - S;
  }

  ///   Q = C + R u - h n,   q = Q.u - sqrt(S^2 - (Q.n)^2) - l: the working mode of the paper (4)
  static std::optional<ChainMotion> drive(const ChainValues& p, const MovingPose& X) {
    const auto& [alpha, beta, r, S, l, R, h] = p;
    const std::array<Moving, 2> C = platform_joint<Moving>(r, beta, X);
    const double ca = std::cos(alpha), sa = std::sin(alpha);
    const Moving along = C[0] * ca + C[1] * sa + R, across = C[1] * ca - C[0] * sa - h;
    const Moving square = (S - across) * (S + across);
    if (!(value_of(square) >= 0)) return {};
    const Moving reach = sqrt(square);
    return ChainMotion{along - reach - l,
                       atan2(reach * sa + across * ca, reach * ca - across * sa)};
  }

  static std::optional<std::string_view> fault(const ChainValues&) { return {}; }
};

}  // namespace

constinit const ChainKind kPrrChain = kind_by<Prr>("PRR");

}  // namespace trammel
