// Is the stated sigma, or are orientations, of another unit than their scatter shows?

#include <algorithm>
#include <cmath>

#include "core/measure/bad_readings.hpp"
#include "core/measure/doubt_kinds.hpp"
#include "core/measure/lie.hpp"
#include "core/measure/noise.hpp"
#include "core/measure/printed.hpp"
#include "core/statistics/robust.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

constexpr int kEnoughFreedom = 12;
// Residuals of a smooth field are an upper bound of the noise: chi^2 of 12 degrees stays above
// 12/16 but for 1 in 10^5, and the quantile that stands for it is half as sure.
constexpr double kTooGood = 0.25;
constexpr double kTooBad = 10;     // repeats beyond the statement by a factor of units
constexpr double kWithinUnit = 3;  // a ratio so near to a unit's is that unit
// At that arm turning errors are 0.14 to 1.1 times those of place on 3-PRR robots of 12 kinds of
// errors, and 57 times smaller once they are radians.
constexpr double kTurnsWithPlace = 0.05;
constexpr double kRadPerDeg = rad_from_deg(1);

/// At one orientation, where deviations of orientations are by far smaller than those of positions
/// make likely: legs in error move and turn a platform alike.
bool turns_too_little(const Campaign& c) {
  double low = INFINITY, high = -INFINITY;
  std::vector<double> x, y, phi;
  for (const Reading& r : c.readings) {
    low = std::min(low, r.target.phi_rad);
    high = std::max(high, r.target.phi_rad);
    if (!r.measured) continue;
    x.push_back(r.measured->x_mm - r.target.x_mm);
    y.push_back(r.measured->y_mm - r.target.y_mm);
    phi.push_back(std::remainder(r.measured->phi_rad - r.target.phi_rad, 2 * kPi));
  }
  if (high - low >= poses::kOneOrientationRad) return false;
  return robust_scatter(phi) * poses::kArmMm <
         kTurnsWithPlace * std::hypot(robust_scatter(x), robust_scatter(y));
}

/// Ratios of what scatters about a smooth field and what is stated; 1 for what is not measured.
struct Scatter {
  SmoothResidual left;
  double xy_mm = 0;  // per coordinate
  double xy = 1, phi = 1;
  bool judged = false;

  explicit Scatter(const Campaign& c) : left(smooth_residual(c)) {
    const Coordinates& is_measured = c.machine.measured;
    const int n_xy = (is_measured[0] ? 1 : 0) + (is_measured[1] ? 1 : 0);
    xy_mm = std::hypot(left.x_mm, left.y_mm) / std::sqrt(std::max(1, n_xy));
    if (n_xy > 0) xy = xy_mm / c.tracker->xy_mm;
    if (is_measured[2]) phi = left.phi_rad / c.tracker->phi_rad;
    judged = left.degrees_of_freedom >= kEnoughFreedom;
  }
};

bool near_unit(double ratio, double unit) {
  return ratio > unit / kWithinUnit && ratio < unit * kWithinUnit;
}

/// Orientations in radians where their scatter alone can tell; of `part`, empty: of all readings.
void add_radians(const Campaign& c, const Scatter& of, const std::string& part,
                 std::vector<Suspicion>& found) {
  if (!of.judged || of.xy < kTooGood || !near_unit(of.phi, kRadPerDeg) || !turns_too_little(c))
    return;
  std::vector<int> seqs;
  for (const Reading& r : c.readings) {
    if (!part.empty()) seqs.push_back(r.seq);
  }
  found.push_back(
      {Mistake::radians,
       part + printed("measured orientations are radians where degrees are due (slope %.4g)",
                      kRadPerDeg),
       printed("they scatter by %.2g deg, %.3g of the stated %.2g deg, while positions "
               "scatter as stated, and deviate by as little",
               deg_from_rad(of.left.phi_rad), of.phi, deg_from_rad(c.tracker->phi_rad)),
       seqs});
}

/// Of all, else of one set.
void add_radians(const Campaign& c, const Scatter& of, std::vector<Suspicion>& found) {
  add_radians(c, of, "", found);
  for (const auto& [set, words] :
       {std::pair(ReadingSet::identify, "of the identify readings alone: "),
        std::pair(ReadingSet::validate, "of the validation readings alone: ")}) {
    if (is_gross(found)) return;
    Campaign some = c;
    std::erase_if(some.readings, [set = set](const Reading& r) { return r.set != set; });
    if (some.readings.size() < c.readings.size()) add_radians(some, Scatter(some), words, found);
  }
}

/// Sigma by far larger than what scatters, or smaller than what repeats show.
void add_sigma(const Campaign& c, const Scatter& of, std::vector<Suspicion>& found) {
  const Coordinates& is_measured = c.machine.measured;
  const auto& [left, left_xy_mm, xy, phi, judged] = of;
  if (judged && (xy < kTooGood || phi < kTooGood)) {
    const bool is_xy = xy < kTooGood;
    const double ratio = is_xy ? xy : phi;
    found.push_back(
        {Mistake::sigma_unit,
         printed("is the stated sigma in the right unit%s? It is %.3g %s",
                 is_xy && near_unit(ratio, 1e-3) ? " (it looks like micrometres for mm)" : "",
                 is_xy ? c.tracker->xy_mm : deg_from_rad(c.tracker->phi_rad), is_xy ? "mm" : "deg"),
         printed("readings scatter about a smooth field by %.2g %s, %.2g of the stated noise",
                 is_xy ? left_xy_mm : deg_from_rad(left.phi_rad), is_xy ? "mm" : "deg", ratio)});
    return;
  }
  const char* small_xy = judged && near_unit(xy, 1e3) ? " (it looks like metres for mm)" : "";
  const char* small_phi =
      judged && near_unit(phi, deg_from_rad(1)) && near_unit(phi / xy, deg_from_rad(1))
          ? " (it looks like radians for deg)"
          : "";
  if (*small_xy != 0 || *small_phi != 0) {
    found.push_back(
        {Mistake::sigma_unit,
         printed("is the stated sigma in the right unit? It is %.3g mm%s and %.3g deg%s",
                 c.tracker->xy_mm, small_xy, deg_from_rad(c.tracker->phi_rad), small_phi),
         printed("readings scatter about a smooth field by %.2g mm and %.2g deg", left_xy_mm,
                 deg_from_rad(left.phi_rad))});
    return;
  }
  const auto repeats = pooled_noise(c.readings, is_measured);
  if (!repeats || repeats->degrees_of_freedom < kEnoughFreedom) return;
  if (!((is_measured[0] || is_measured[1]) && repeats->sigma.xy_mm >= kTooBad * c.tracker->xy_mm) &&
      !(is_measured[2] && repeats->sigma.phi_rad >= kTooBad * c.tracker->phi_rad))
    return;
  found.push_back({Mistake::sigma_unit,
                   printed("is the stated sigma in the right unit? It is %.3g mm and %.3g deg",
                           c.tracker->xy_mm, deg_from_rad(c.tracker->phi_rad)),
                   printed("repeats scatter by %.2g mm and %.2g deg", repeats->sigma.xy_mm,
                           deg_from_rad(repeats->sigma.phi_rad))});
}

}  // namespace

void add_doubts_of_sigma(const Campaign& c, std::vector<Suspicion>& found) {
  if (!c.tracker) return;
  const Scatter of(c);
  add_radians(c, of, found);
  if (!is_gross(found)) add_sigma(c, of, found);
}

}  // namespace trammel
