// PPR: a driven slider along alpha that carries a passive guide along gamma, on which the
// platform's joint C slides. Two make an XY stage, one an axis, three a UVW or XXY stage.

#include "core/mechanism/chain_formula.hpp"

namespace trammel {

namespace {

///   f = n_gamma . C - c - (q + l) (n_gamma . u_alpha),   n_gamma = (-sin, cos)(gamma)
struct Ppr {
  static constexpr std::string_view drive_word = "axis";
  static constexpr std::size_t zero = 2;
  static constexpr std::optional<std::size_t> offset = 3;
  static constexpr std::array<ChainParameter, 6> parameters = {{
      {.symbol = "alpha", .field = "alpha_deg"},
      {.symbol = "gamma", .field = "gamma_deg"},
      {.symbol = "l", .field = "l_zero_mm", .optional = true},
      {.symbol = "c", .field = "c_mm", .optional = true},
      {.symbol = "r",
       .field = "r_mm",
       .range = ValueRange::not_negative,
       .optional = true,
       .platform = true},
      {.symbol = "beta", .field = "beta_deg", .optional = true, .platform = true},
  }};

  template <class T>
  static T closure(const std::array<T, 6>& p, const T& q, const std::array<T, 3>& X) {
    using std::cos, std::sin;
    const auto& [alpha, gamma, l, c, r, beta] = p;
    const std::array<T, 2> C = platform_joint(r, beta, X);
    const T nx = -sin(gamma), ny = cos(gamma);
    return nx * C[0] + ny * C[1] - c - (q + l) * (nx * cos(alpha) + ny * sin(alpha));
  }

  ///   q = (n_gamma . C - c) / (n_gamma . u_alpha) - l
  static std::optional<ChainMotion> drive(const ChainValues& p, const MovingPose& X) {
    const auto& [alpha, gamma, l, c, r, beta, unused] = p;
    const std::array<Moving, 2> C = platform_joint<Moving>(r, beta, X);
    const double nx = -std::sin(gamma), ny = std::cos(gamma);
    const Moving across = nx * C[0] + ny * C[1] - c;
    return ChainMotion{across / across_drive(alpha, gamma) - l, {}};
  }

  /// n_gamma . u_alpha = sin(alpha - gamma)
  static double across_drive(double alpha, double gamma) { return std::sin(alpha - gamma); }

  static OnGuide on_guide(const ChainValues& p, double q, const Pose& X) {
    const auto& [alpha, gamma, l, c, r, beta, unused] = p;
    const std::array<double, 2> C = platform_joint<double>(r, beta, {X.x_mm, X.y_mm, X.phi_rad});
    const double along = C[0] * std::cos(gamma) + C[1] * std::sin(gamma);
    return {along, along - (q + l) * std::cos(alpha - gamma)};
  }

  /// f_alpha = -(q + l) cos(alpha - gamma): a tolerance t moves the joint by cos(alpha - gamma) t
  /// of q at first order, and by t^2 / 2 at second. What it then does is a lead's error.
  static bool second_order(const ChainValues& p, std::size_t place) {
    return place == 0 && std::abs(std::cos(p[0] - p[1])) < parameters[0].tolerance() / 2;
  }

  static std::optional<std::string_view> fault(const ChainValues& p) {
    // As a machine's singular poses: a guide within 1e-6 rad of its drive moves the platform by
    // less than a nanometre for a millimetre of drive.
    if (std::abs(across_drive(p[0], p[1])) > 1e-6) return {};
    return "the passive guide lies along its own drive, which moves nothing: gamma_deg other than "
           "alpha_deg, or opposite to it";
  }
};

}  // namespace

constinit const ChainKind kPprChain = kind_by<Ppr>("PPR");

}  // namespace trammel
