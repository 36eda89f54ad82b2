#include "core/measure/screen.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <functional>
#include <numeric>
#include <optional>

#include "core/measure/point_outliers.hpp"
#include "core/mechanism/inverse.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

constexpr double kMadToSigma = 1.4826;    // of a normal distribution
constexpr double kFarBetter = 5;          // a hypothesis must fit so many times better
constexpr double kAlike = 2;              // two that fit within this factor are both named
constexpr double kMostUnreachable = 0.2;  // of the readings
constexpr double kNoNoiseMm = 1e-3;       // closer to the plan than any measurement comes
constexpr double kOneUnit = 0.02;         // two scales are one unit
constexpr double kNotTurnedRad = rad_from_deg(2);

using Displaced = std::optional<Displacements>;
using Poses = std::vector<Pose>;

/// One mistake: what undoes it, on poses and on what the inverse kinematics make of them.
struct Hypothesis {
  Mistake kind;
  std::string what;
  std::function<Pose(const Pose&)> pose = [](const Pose& p) { return p; };
  std::function<Displacements(const Displacements&)> drives = [](const Displacements& l) {
    return l;
  };
  bool other_branch = false;
};

/// How the measured positions lie on the targets.
struct Similarity {
  double turn_rad = 0;
  double scale = 1;
};

/// m = s R(t) p by least squares in the complex plane: z = sum conj(p) m / sum |p|^2; mirrored: of
/// conj(p).
Similarity similarity(const Poses& target, const Poses& measured, bool mirrored) {
  using Complex = std::complex<double>;
  const auto at = [](const Pose& p) { return Complex(p.x_mm, p.y_mm); };
  Complex mean_p = 0, mean_m = 0;
  for (std::size_t i = 0; i < target.size(); ++i) {
    mean_p += at(target[i]) / static_cast<double>(target.size());
    mean_m += at(measured[i]) / static_cast<double>(target.size());
  }
  Complex sum = 0;
  double pp = 0;
  for (std::size_t i = 0; i < target.size(); ++i) {
    const Complex p = at(target[i]) - mean_p;
    const Complex m = at(measured[i]) - mean_m;
    sum += (mirrored ? p : std::conj(p)) * m;
    pp += std::norm(p);
  }
  if (!(pp > 0)) return {};
  return {std::arg(sum), std::abs(sum) / pp};
}

/// Direction of the mean of unit vectors: angles count modulo a turn.
double circular_mean_rad(const std::vector<double>& angles_rad) {
  double c = 0, s = 0;
  for (const double a : angles_rad) {
    c += std::cos(a);
    s += std::sin(a);
  }
  return std::atan2(s, c);
}

Pose turned(const Pose& p, double by_rad) {
  const double c = std::cos(by_rad), s = std::sin(by_rad);
  return {c * p.x_mm - s * p.y_mm, s * p.x_mm + c * p.y_mm, p.phi_rad + by_rad};
}

Pose mirrored(const Pose& p) { return {p.x_mm, -p.y_mm, -p.phi_rad}; }

/// (4) of inverse.hpp with the branch asked for: the plus sign is the other working mode.
Displaced displacements_at(const Geometry& geometry, const Pose& pose, bool other_branch) {
  const InverseResult at = inverse(geometry, pose);
  if (!at.ok()) return std::nullopt;
  if (!other_branch) return at.l_mm;
  Displacements l = at.l_mm;
  for (int i = 0; i < kChains; ++i) {
    const Chain& chain = geometry.chains[static_cast<std::size_t>(i)];
    // Q.u - root becomes Q.u + root; the link's angle says the root: S cos(alpha - theta)
    l[i] += 2 * chain.S_mm * std::cos(chain.alpha_rad - at.theta_rad[i]);
  }
  return l;
}

/// d(H); nothing when too many of the poses are out of reach.
std::optional<double> distance(const Campaign& campaign, const std::vector<Displacements>& commands,
                               const Poses& poses, const Hypothesis& h) {
  std::array<std::vector<double>, kChains> off;
  std::size_t reached = 0;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const Displaced l =
        displacements_at(campaign.mechanism.geometry, h.pose(poses[k]), h.other_branch);
    if (!l) continue;
    ++reached;
    const Displacements d = commands[k] - h.drives(*l);
    for (int i = 0; i < kChains; ++i) off[static_cast<std::size_t>(i)].push_back(d[i]);
  }
  if (static_cast<double>(reached) < (1 - kMostUnreachable) * static_cast<double>(poses.size()))
    return std::nullopt;
  double sum = 0;
  for (auto& drive : off) {
    const double middle = median(drive);
    for (double& v : drive) v = std::abs(v - middle);
    sum += std::pow(kMadToSigma * median(drive), 2) / kChains;
  }
  return std::sqrt(sum);
}

std::string degrees(double rad) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", deg_from_rad(rad));
  return text;
}

std::string drives_in_words(const std::vector<int>& drives) {
  std::string text;
  for (std::size_t i = 0; i < drives.size(); ++i) {
    if (i > 0) text += i + 1 == drives.size() ? " and " : ", ";
    text += std::to_string(drives[i] + 1);
  }
  return text;
}

void add_drives(std::vector<Hypothesis>& all) {
  std::array<int, kChains> order;
  std::iota(order.begin(), order.end(), 0);
  while (std::next_permutation(order.begin(), order.end())) {
    std::vector<int> moved;
    for (int i = 0; i < kChains; ++i) {
      if (order[static_cast<std::size_t>(i)] != i) moved.push_back(i);
    }
    all.push_back({.kind = Mistake::drives_swapped,
                   .what = "drives " + drives_in_words(moved) +
                           (moved.size() == 2 ? " are swapped" : " have changed places"),
                   .drives = [order](const Displacements& l) {
                     return Displacements(l[order[0]], l[order[1]], l[order[2]]);
                   }});
  }
  for (unsigned signs = 1; signs < 1U << kChains; ++signs) {
    Displacements sign = Displacements::Ones();
    std::vector<int> reversed;
    for (int i = 0; i < kChains; ++i) {
      if ((signs >> i & 1U) == 0) continue;
      sign[i] = -1;
      reversed.push_back(i);
    }
    all.push_back({.kind = Mistake::drive_reversed,
                   .what = (reversed.size() == 1 ? "drive " : "drives ") +
                           drives_in_words(reversed) +
                           (reversed.size() == 1 ? " counts backwards" : " count backwards"),
                   .drives = [sign](const Displacements& l) {
                     return Displacements(sign.cwiseProduct(l));  // its zero is a constant
                   }});
  }
}

void add_frames(std::vector<Hypothesis>& all, const Poses& target, const Poses& poses) {
  const Similarity straight = similarity(target, poses, false);
  const Similarity mirror = similarity(target, poses, true);
  std::vector<double> phi_off, phi_sum;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    phi_off.push_back(poses[i].phi_rad - target[i].phi_rad);
    phi_sum.push_back(poses[i].phi_rad + target[i].phi_rad);
  }
  const double turn = circular_mean_rad(phi_off);
  if (std::abs(turn) > kNotTurnedRad) {
    all.push_back({.kind = Mistake::phi_offset,
                   .what = "all orientations are " + degrees(turn) + " deg off",
                   .pose = [turn](const Pose& p) {
                     return Pose{p.x_mm, p.y_mm, p.phi_rad - turn};
                   }});
  }
  if (std::abs(straight.turn_rad) > kNotTurnedRad) {
    const double by = straight.turn_rad;
    all.push_back({.kind = Mistake::frame_turned,
                   .what = "the frame of the readings is turned by " + degrees(by) + " deg",
                   .pose = [by](const Pose& p) { return turned(p, -by); }});
    all.push_back({.kind = Mistake::frame_turned,
                   .what = "positions are turned by " + degrees(by) +
                           " deg about the origin, orientations are not",
                   .pose = [by](const Pose& p) {
                     const Pose back = turned(p, -by);
                     return Pose{back.x_mm, back.y_mm, p.phi_rad};
                   }});
  }
  const double by = mirror.turn_rad;  // of the mirrored frame
  all.push_back({.kind = Mistake::frame_mirrored,
                 .what = "the frame of the readings is mirrored",
                 .pose = [by](const Pose& p) { return mirrored(turned(p, -by)); }});
  all.push_back({.kind = Mistake::frame_mirrored,
                 .what = "positions are mirrored, orientations are not",
                 .pose = [by](const Pose& p) {
                   const Pose back = mirrored(turned(p, -by));
                   return Pose{back.x_mm, back.y_mm, p.phi_rad};
                 }});
  all.push_back({.kind = Mistake::frame_mirrored,
                 .what = "orientations count the wrong way round",
                 .pose = [](const Pose& p) {
                   return Pose{p.x_mm, p.y_mm, -p.phi_rad};
                 }});
}

void add_units(std::vector<Hypothesis>& all, const Poses& target, const Poses& poses) {
  std::vector<double> scales = {25.4, 1 / 25.4, 1000, 0.001, 10, 0.1};
  const double seen = similarity(target, poses, false).scale;
  const bool known = std::any_of(scales.begin(), scales.end(),
                                 [seen](double s) { return std::abs(seen / s - 1) < kOneUnit; });
  if (!known && seen > 0) scales.push_back(seen);
  for (const double s : scales) {
    char what[64];
    std::snprintf(what, sizeof what, "measured lengths are %.4g times too large", s);
    all.push_back({.kind = Mistake::scale, .what = what, .pose = [s](const Pose& p) {
                     return Pose{p.x_mm / s, p.y_mm / s, p.phi_rad};
                   }});
  }
  for (const bool small : {true, false}) {
    const double factor = small ? deg_from_rad(1.0) : rad_from_deg(1.0);
    all.push_back({.kind = Mistake::radians,
                   .what = small ? "orientations are radians where degrees are due"
                                 : "orientations were converted from degrees twice",
                   .pose = [factor](const Pose& p) {
                     return Pose{p.x_mm, p.y_mm, p.phi_rad * factor};
                   }});
  }
}

struct Fitted {
  Suspicion suspicion;
  double left_mm;
};

std::string fits(double so_mm, double as_is_mm) {
  char text[128];
  std::snprintf(text, sizeof text,
                "commands fit the inverse kinematics of the readings to %.2g mm so, to %.2g mm as "
                "they are",
                so_mm, as_is_mm);
  return text;
}

}  // namespace

std::string to_string(Mistake mistake) {
  constexpr const char* kNames[] = {
      "drives_swapped", "drive_reversed", "phi_offset", "frame_turned", "frame_mirrored", "scale",
      "radians",        "working_mode",   "exchanged",  "shifted_rows", "mechanism"};
  return kNames[static_cast<std::size_t>(mistake)];
}

std::vector<Suspicion> gross_mistakes(const Campaign& campaign) {
  std::vector<Displacements> commands;
  Poses target, measured;
  for (const Reading& r : campaign.readings) {
    if (!r.measured) continue;
    commands.push_back(r.conditions.cmd_mm);
    target.push_back(r.target);
    measured.push_back(*r.measured);
  }
  if (commands.size() < static_cast<std::size_t>(kFewestScreened)) return {};
  const auto n = static_cast<double>(commands.size());
  Displacements mean = Displacements::Zero();
  for (const Displacements& c : commands) mean += c / n;
  double spread = 0;
  for (const Displacements& c : commands) spread += (c - mean).squaredNorm() / (kChains * n);
  spread = std::sqrt(spread);
  const Hypothesis as_is{.kind = Mistake::mechanism, .what = ""};
  const auto of_measured = distance(campaign, commands, measured, as_is);
  const auto of_target = distance(campaign, commands, target, as_is);
  const double now = of_measured ? *of_measured : INFINITY;
  if (of_measured && now < kNoNoiseMm && (!of_target || *of_target > kNoNoiseMm)) {
    return {{Mistake::exchanged,
             "measured and target poses have changed places",
             "commands are the exact inverse kinematics of the measured poses, not of the targets",
             {}}};
  }
  if (now <= kSoundShare * spread || spread <= 0) return {};

  std::vector<Hypothesis> all;
  add_drives(all);
  add_frames(all, target, measured);
  add_units(all, target, measured);
  all.push_back({.kind = Mistake::working_mode,
                 .what = "the links stand in the other working mode",
                 .other_branch = true});
  std::vector<Fitted> fitted;
  const auto consider = [&](Mistake kind, const std::string& what, std::optional<double> left) {
    if (left && *left < kSoundShare * spread && *left * kFarBetter < now)
      fitted.push_back({{kind, what, fits(*left, now), {}}, *left});
  };
  for (const Hypothesis& h : all)
    consider(h.kind, h.what, distance(campaign, commands, measured, h));
  for (const bool late : {true, false}) {
    const std::vector<Displacements> part(commands.begin() + (late ? 0 : 1),
                                          commands.end() - (late ? 1 : 0));
    const Poses poses(measured.begin() + (late ? 1 : 0), measured.end() - (late ? 0 : 1));
    consider(Mistake::shifted_rows,
             late ? "measured poses stand one row too late" : "measured poses stand one row early",
             distance(campaign, part, poses, as_is));
  }
  std::stable_sort(fitted.begin(), fitted.end(),
                   [](const Fitted& a, const Fitted& b) { return a.left_mm < b.left_mm; });
  std::vector<Suspicion> found;
  for (const Fitted& f : fitted) {
    if (f.left_mm > kAlike * fitted.front().left_mm || found.size() == 2) break;
    const bool named = std::any_of(found.begin(), found.end(),
                                   [&](const Suspicion& s) { return s.kind == f.suspicion.kind; });
    if (!named) found.push_back(f.suspicion);
  }
  if (found.empty() && (!of_target || *of_target > kSoundShare * spread)) {
    char why[128];
    std::snprintf(why, sizeof why,
                  "commands are %.2g mm off the inverse kinematics of the readings and %.2g mm off "
                  "that of the targets",
                  now, of_target.value_or(INFINITY));
    found.push_back({Mistake::mechanism, "the commands do not belong to this mechanism", why, {}});
  }
  return found;
}

}  // namespace trammel
