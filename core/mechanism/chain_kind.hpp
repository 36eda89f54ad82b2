#pragma once
// A kind of chain: one scalar equation f(p, q, X) = 0 of its parameters p, its drive q and the
// platform's pose X. Everything else about a machine follows from it (machine_kinematics.hpp).

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <string_view>

#include "core/linear/dual.hpp"
#include "core/mechanism/pose.hpp"
#include "core/units.hpp"

namespace trammel {

enum class ValueRange { any, positive, not_negative };

struct ChainParameter {
  std::string_view symbol;  // in vectors and sentences, with the chain's number: "alpha_1"
  std::string_view field;   // in files, with its unit: "alpha_deg"
  ValueRange range = ValueRange::any;
  bool optional = false;   // in files: 0 where it is not stated
  bool completes = false;  // not of the paper: comes after the other parameters of all chains
  bool platform = false;   // of the platform: a machine whose platform is a point has it not

  [[nodiscard]] constexpr bool is_angle() const { return field.ends_with("_deg"); }
  /// One standard deviation of machining and assembly of a bench-size machine: 0.05 deg, 0.1 mm.
  [[nodiscard]] constexpr double tolerance() const { return is_angle() ? rad_from_deg(0.05) : 0.1; }
};

/// Values in the order of the kind's parameters, rad and mm; zeros behind them.
inline constexpr std::size_t kMostChainParameters = 7;
using ChainValues = std::array<double, kMostChainParameters>;

/// f [mm] at one pose and all its derivatives.
struct ClosureRow {
  double f = 0;
  double f_q = 0;
  Eigen::RowVector3d f_X = {};  // by x, y [mm], phi [rad]
  ChainValues f_p = {};
};

/// The platform on its way: x, y, phi.
using MovingPose = std::array<Moving, 3>;

struct ChainMotion {
  Moving q;                     // mm, mm/s, mm/s^2
  std::optional<Moving> angle;  // rad: of the link or cylinder against X, where the kind has one
};

/// Where a joint stands on a passive guide.
struct OnGuide {
  double along_mm = 0;  // u_gamma . C
  double lever_mm = 0;  // u_gamma . (C - (q + l) u_alpha): from the driven slider
};

struct ChainKind {
  std::string_view name;
  std::span<const ChainParameter> parameters;
  /// By dual numbers.
  ClosureRow (*closure)(const ChainValues& p, double q_mm, const Pose& X);
  /// f = 0 solved for q in closed form; nothing where the chain does not reach the pose.
  std::optional<ChainMotion> (*drive)(const ChainValues& p, const MovingPose& X);
  /// What is wrong with values that are each in range, as "what: expected"; else nothing.
  std::optional<std::string_view> (*fault)(const ChainValues& p);
  std::string_view drive_word;  // "rail", "axis", "cylinder"
  /// Places of the drive's zero, which adds to q, and of the offset across the guide where there is
  /// one: of a PRR its rail's, of a PPR its passive guide's.
  std::size_t zero = 0;
  std::optional<std::size_t> offset;
  /// Null where the guide is the driven rail itself, or there is none.
  OnGuide (*on_guide)(const ChainValues& p, double q_mm, const Pose& X);
  /// Whether a tolerance of a parameter does less at first order than at second, at these values:
  /// no fit moves it. Null: every parameter acts at first order.
  bool (*second_order)(const ChainValues& p, std::size_t place);
};

/// One file a kind; its closure is written there as a formula and nowhere else. Proof of all:
/// golden numbers of an independent program, finite differences (machine_test.cpp).
extern const ChainKind kPrrChain, kPprChain, kRprChain;

}  // namespace trammel
