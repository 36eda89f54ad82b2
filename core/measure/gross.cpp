#include "core/measure/gross.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "core/measure/bad_readings.hpp"
#include "core/measure/drive_hypotheses.hpp"
#include "core/measure/lie.hpp"
#include "core/measure/lie_words.hpp"
#include "core/measure/printed.hpp"
#include "core/mechanism/machine_solver.hpp"
#include "core/statistics/robust.hpp"
#include "core/units.hpp"

namespace trammel {

using namespace poses;

namespace {

constexpr double kNearlyAll = 0.95;          // ends of lines too, which a shifted frame leaves
constexpr double kNearlyAllOfNormal = 1.96;  // |N(0, 1)| stays below it in 95 %
constexpr double kAlike = 2;                 // two that fit within this factor are both named
constexpr double kManyApart = 0.35;          // of the readings
constexpr double kMostUnreachable = 0.2;     // of the readings
constexpr double kNoNoiseMm = 1e-3;          // closer to the plan than any measurement comes
constexpr double kDeviates = 0.2;            // of the width: what errors alone may be
constexpr double kOtherLengthMm = 0.5;       // of R, r or S: no machining is that far off
constexpr double kExactMm = 1e-4;            // digits of commands
constexpr double kLeastMm = 0.5;             // closer nothing gross is seen, however near the poses
// What small machines may be off, of the width of targets or commands: a tenth is what a similarity
// may leave.
constexpr double kShareOfSmall = 0.2;
constexpr double kShareOfStep = 0.03;  // targets nearer together are one place
constexpr double kMicrometres = 1e3;   // in a millimetre
constexpr std::array<double, 5> kLengthUnits = {1e-3, 1 / 25.4, 0.1, kMicrometres, 25.4};
constexpr double kThird = 1.0 / 3;     // of the rows: where so many are on target, those are poses
constexpr double kSmoothShare = 0.5;   // of their spread: what a smooth field leaves of errors
constexpr double kFollowsShare = 0.3;  // of their spread: what is left where they follow
constexpr double kManyOrientations = 10;  // of one: fewer are scatter
constexpr int kMostRows = 10;             // that columns may be shifted by

using Commands = std::vector<Displacements>;

// --- commands against poses -----------------------------------------------------------------

/// Commands less the inverse kinematics of poses, over all drives.
struct Distance {
  double scatter_mm = INFINITY;  // about each drive's median: joint zeros are free
  double whole_mm = INFINITY;    // and with the medians
  Displacements zero_mm = Displacements::Zero();
};

/// Infinite where too many of the poses are out of reach. Row k of the commands goes with row
/// k + shift of the poses.
Distance distance(const DriveModel& model, const Commands& commands, const Poses& poses,
                  int shift = 0) {
  const int n_drives = model.solver.machine().kind->n_chains;
  std::array<std::vector<double>, kChains> off;
  std::size_t reached = 0, asked = 0;
  const auto n = static_cast<int>(poses.size());
  for (int k = std::max(0, -shift); k < n - std::max(0, shift); ++k) {
    ++asked;
    const Displaced l = displacements_at(model, poses[static_cast<std::size_t>(k + shift)]);
    if (!l) continue;
    ++reached;
    const Displacements d = commands[static_cast<std::size_t>(k)] - *l;
    for (int i = 0; i < n_drives; ++i) off[static_cast<std::size_t>(i)].push_back(d[i]);
  }
  Distance result;
  if (reached == 0 ||
      static_cast<double>(reached) < (1 - kMostUnreachable) * static_cast<double>(asked))
    return result;
  double scatter2 = 0, zero2 = 0;
  for (int i = 0; i < n_drives; ++i) {
    std::vector<double>& drive = off[static_cast<std::size_t>(i)];
    result.zero_mm[i] = median(drive);
    for (double& v : drive) v -= result.zero_mm[i];
    scatter2 += std::pow(robust_sigma(drive), 2) / n_drives;
    zero2 += std::pow(result.zero_mm[i], 2) / n_drives;
  }
  result.scatter_mm = std::sqrt(scatter2);
  result.whole_mm = std::sqrt(scatter2 + zero2);
  return result;
}

// --- hypotheses -----------------------------------------------------------------------------

/// One length of all chains.
struct Length {
  const char* name;
  double Chain::*of;
};
constexpr std::array<Length, 3> kLengths = {
    {{"R", &Chain::R_mm}, {"r", &Chain::r_mm}, {"S", &Chain::S_mm}}};

MachineSolver longer(Geometry geometry, const Length& length, double by_mm) {
  for (Chain& chain : geometry.chains) chain.*(length.of) += by_mm;
  return MachineSolver(machine_of({.geometry = geometry, .home = {}, .limits = {}}));
}

constexpr const char* kLie = "measured poses lie on the targets";

class Search {
 public:
  explicit Search(const Campaign& campaign) : campaign_(campaign), solver_(campaign.machine) {
    for (const Reading& r : campaign.readings) {
      if (!r.measured) continue;
      commands_.push_back(r.conditions.cmd_mm);
      targets_.push_back(r.target);
      measured_.push_back(*r.measured);
    }
    home_ = solver_.drives(solver_.machine().home);
  }

  [[nodiscard]] bool enough() const {
    return commands_.size() >= static_cast<std::size_t>(kFewestScreened);
  }

  /// `last_resort`: with what fits many things.
  std::vector<Suspicion> found(bool last_resort) {
    Displacements mean = Displacements::Zero();
    const auto n = static_cast<double>(commands_.size());
    for (const Displacements& c : commands_) mean += c / n;
    const int n_drives = solver_.machine().kind->n_chains;
    for (const Displacements& c : commands_)
      spread_mm_ += (c - mean).squaredNorm() / (n_drives * n);
    spread_mm_ = std::sqrt(spread_mm_);
    of_measured_ = distance({solver_}, commands_, measured_);
    of_targets_ = distance({solver_}, commands_, targets_);
    if (exchanged()) {
      return {{Mistake::exchanged, "measured and target poses have changed places",
               printed("commands are the inverse kinematics of the measured poses to %.2g mm, of "
                       "the targets to %.2g mm",
                       of_measured_.whole_mm, of_targets_.whole_mm)}};
    }
    sound_mm_ = std::max(kSoundShare * spread_mm_, std::min(kLeastMm, kShareOfSmall * spread_mm_));
    lie_ = lie(targets_, measured_);
    if (lie_.width_mm > kNarrowMm) {
      most_mm_ = std::min(kMostShiftedMm, kShareOfSmall * lie_.width_mm);
      other_mm_ = std::min(kMostShiftedMm, kShareOfStep * lie_.width_mm);
    }
    const bool targets_lie = of_measured_.whole_mm < of_targets_.whole_mm &&
                             !parts_of(lie(measured_, targets_), "target").empty();
    const bool poses_lie = !parts_of(lie_, "measured").empty() || targets_lie || deviating();
    const bool commands_lie =
        of_targets_.scatter_mm > sound_mm_ || of_targets_.whole_mm > kMostShiftedMm;
    const bool robot_lies = of_measured_.scatter_mm > sound_mm_;
    shifted_rows();
    if (poses_lie) of_poses();
    if (fitted_.empty() && !lie_.similar()) of_columns();
    if (last_resort && fitted_.empty() && !lie_.similar()) of_micrometres();
    if (last_resort && fitted_.empty() && lie_.similar()) of_orientations();
    if (robot_lies) of_wires();
    if (commands_lie && !(poses_lie && of_measured_.whole_mm < of_targets_.whole_mm)) of_commands();
    other_lengths();
    return chosen(robot_lies, commands_lie);
  }

 private:
  [[nodiscard]] bool exchanged() const {
    return of_measured_.whole_mm < kNoNoiseMm && of_targets_.whole_mm > kNoNoiseMm &&
           of_targets_.whole_mm > kFarBetter * of_measured_.whole_mm;
  }

  void consider(Mistake kind, const std::string& what, double left_mm, double now_mm,
                const char* relation, double bound_mm) {
    if (!(left_mm < bound_mm && left_mm * kFarBetter < now_mm)) return;
    const std::string as_is = std::isfinite(now_mm) ? printed("to %.2g mm", now_mm) : "not at all";
    fitted_.push_back(
        {{kind, what,
          std::string(relation) + printed(" to %.2g mm so, ", left_mm) + as_is + " as they are"},
         std::max(left_mm, kNothingMm)});
  }

  /// Small everywhere, and no orientation in it, or that of the targets: what was measured less the
  /// target.
  [[nodiscard]] bool deviating() const {
    if (lie_.similar() && unit_of(lie_.place.scale)) return false;
    std::vector<double> place, phi, target_phi;
    const double middle = middle_of(targets_);
    for (std::size_t k = 0; k < measured_.size(); ++k) {
      place.push_back(std::abs(place_of(measured_[k])));
      phi.push_back(measured_[k].phi_rad);
      target_phi.push_back(wrapped(targets_[k].phi_rad - middle));
    }
    const double turned = robust_sigma(target_phi);
    return robust_sigma(place) < kDeviates * lie_.width_mm &&
           (turned < kOneOrientationRad || robust_sigma(phi) * kAlike < turned || follows());
  }

  /// Orientations are those of the targets, whatever positions are.
  [[nodiscard]] bool follows() const {
    const AngleFit& angle = lie_.angle;
    if (lie_.similar() && lie_.place.scale > kMostScaled) return false;  // a unit, not errors
    return angle.slope == 1 && angle.left_rad < kOneOrientationRad &&
           std::abs(angle.offset_rad) < kMostTurnedRad;
  }

  static double middle_of(const Poses& poses) {
    std::vector<double> phi;
    for (const Pose& p : poses) phi.push_back(p.phi_rad);
    return middle_of_angles(phi);
  }

  /// The column whose poses the commands contradict is the wrong one.
  void of_poses() {
    if (deviating()) return deviations();
    const bool targets = of_measured_.whole_mm < of_targets_.whole_mm;
    const Lie l = targets ? lie(measured_, targets_) : lie_;
    const Poses& wrong = targets ? targets_ : measured_;
    const std::vector<LiePart> parts = parts_of(l, targets ? "target" : "measured");
    if (!parts.empty()) {
      std::string what;
      for (const LiePart& part : parts) what += (what.empty() ? "" : ", and ") + part.words;
      Poses right;
      for (const Pose& p : wrong) right.push_back(l.back(p));
      const double left_mm = off_mm(targets ? measured_ : targets_, right);
      consider(parts.front().kind, what, left_mm, l.off_mm, kLie, INFINITY);
      if (fitted_.empty() && parts.front().kind == Mistake::radians && parts.size() == 1 &&
          l.angle.is_fitted()) {
        fitted_.push_back({{Mistake::radians, what,
                            printed("they are %.4g +- %.2g times those of the targets",
                                    l.angle.fitted_slope, l.angle.slope_error)},
                           kNothingMm});
      }
      if (!fitted_.empty() && fitted_.back().suspicion.what == what) {  // beside wires: in drives
        const double drives_mm = distance({solver_}, commands_, right).scatter_mm;
        if (std::isfinite(drives_mm)) fitted_.back().left_mm = std::max(drives_mm, kNothingMm);
      }
    }
  }

  /// One column in another unit than the others.
  void of_columns() {
    for (const double unit : kLengthUnits) {
      for (const bool is_x : {true, false}) {
        Poses right = measured_;
        for (Pose& p : right) (is_x ? p.x_mm : p.y_mm) /= unit;
        consider(Mistake::scale, std::string("measured ") + (is_x ? "x " : "y ") + unit_words(unit),
                 off_mm(targets_, right), lie_.off_mm, kLie, kSimilarShare * lie_.width_mm);
      }
    }
  }

  /// Orientations alone that do not follow their targets: deviations, or those of other rows.
  void of_orientations() {
    const double turned = robust_sigma(about_middle(targets_));
    if (turned < kManyOrientations * kOneOrientationRad ||
        lie_.angle.left_rad < kFollowsShare * turned)
      return;
    Poses right = measured_;
    for (std::size_t k = 0; k < right.size(); ++k)
      right[k].phi_rad = targets_[k].phi_rad + measured_[k].phi_rad;
    consider(Mistake::deviations,
             "deviations from the targets, or nothing, stand in place of measured orientations",
             off_mm(targets_, right), lie_.off_mm, kLie, INFINITY);
    for (int by = -kMostRows; by <= kMostRows; ++by) {
      Poses of_targets, of_rows;
      for (int k = std::max(0, -by); k < static_cast<int>(right.size()) - std::max(0, by); ++k) {
        const auto at = static_cast<std::size_t>(k), other = static_cast<std::size_t>(k + by);
        of_targets.push_back(targets_[at]);
        of_rows.push_back({measured_[at].x_mm, measured_[at].y_mm, measured_[other].phi_rad});
      }
      if (by == 0 || of_rows.size() < static_cast<std::size_t>(kFewestScreened) ||
          2 * of_rows.size() < right.size())
        continue;
      consider(Mistake::shifted_rows,
               "measured orientations stand " + rows_in_words(by) +
                   (by > 0 ? " too late" : " too early"),
               off_mm(of_targets, of_rows), lie_.off_mm, kLie, INFINITY);
    }
  }

  static std::vector<double> about_middle(const Poses& poses) {
    const double middle = middle_of(poses);
    std::vector<double> phi;
    for (const Pose& p : poses) phi.push_back(wrapped(p.phi_rad - middle));
    return phi;
  }

  static std::string rows_in_words(int by) {
    return std::to_string(std::abs(by)) + (std::abs(by) == 1 ? " row" : " rows");
  }

  /// Whatever is small lies on its target; errors of a machine also follow the place smoothly.
  void of_micrometres() {
    Campaign as_deviations = campaign_;
    std::vector<double> x, y, off;
    std::size_t k = 0;
    Poses right;
    for (Reading& r : as_deviations.readings) {
      if (!r.measured) continue;
      const Pose& deviation = measured_[k++];
      off.push_back(std::abs(place_of(deviation) - place_of(r.target)));
      x.push_back(deviation.x_mm / kMicrometres);
      y.push_back(deviation.y_mm / kMicrometres);
      r.measured->x_mm = r.target.x_mm + x.back();
      r.measured->y_mm = r.target.y_mm + y.back();
      right.push_back(*r.measured);
      right.back().phi_rad = r.target.phi_rad;
    }
    const SmoothResidual left = smooth_residual(as_deviations);
    const double spread_mm = std::hypot(robust_scatter(x), robust_scatter(y));
    if (left.degrees_of_freedom < kFewestScreened || robust_sigma(off, kThird, 1) < most_mm_ ||
        !(std::hypot(left.x_mm, left.y_mm) < kSmoothShare * spread_mm))
      return;
    consider(Mistake::deviations,
             "deviations from the targets in micrometres stand in place of measured x and y",
             off_mm(targets_, right), lie_.off_mm, kLie, INFINITY);
  }

  void deviations() {
    std::vector<double> phi;
    for (const Pose& p : targets_) phi.push_back(p.phi_rad);
    const auto [low, high] = std::ranges::minmax(phi);
    const bool places_alone = follows() && high - low > kOneOrientationRad;
    Poses right;
    for (std::size_t k = 0; k < measured_.size(); ++k) {
      const Pose& off = measured_[k];
      right.push_back(Pose::from(targets_[k].vector() + off.vector()));
      if (places_alone) right.back().phi_rad = off.phi_rad;
    }
    const bool micrometres = off_mm(targets_, right) > most_mm_;
    for (std::size_t k = 0; k < right.size() && micrometres; ++k) {
      right[k].x_mm = targets_[k].x_mm + measured_[k].x_mm / kMicrometres;
      right[k].y_mm = targets_[k].y_mm + measured_[k].y_mm / kMicrometres;
    }
    consider(Mistake::deviations,
             std::string("deviations from the targets ") + (micrometres ? "in micrometres " : "") +
                 "stand in place of measured " + (places_alone ? "x and y" : "poses"),
             off_mm(targets_, right), lie_.off_mm, kLie, INFINITY);
  }

  /// What the machine did, by its readings.
  void of_wires() {
    for (const DriveHypothesis& h : hypotheses_of_drives(solver_)) {
      consider(h.kind, h.what, distance(h.model, commands_, measured_).scatter_mm,
               of_measured_.scatter_mm, "commands fit the inverse kinematics of the readings",
               kSoundShare * spread_mm_);
    }
  }

  /// What the columns of commands hold.
  void of_commands() {
    constexpr const char* kFit = "commands fit the inverse kinematics of the targets";
    const double bound_mm = std::min(kSoundShare * spread_mm_, kMostShiftedMm);
    const double now_mm = of_targets_.whole_mm;
    for (const DriveHypothesis& h : hypotheses_of_drives(solver_)) {
      consider(h.kind, h.what, distance(h.model, commands_, targets_).scatter_mm,
               of_targets_.scatter_mm, kFit, bound_mm);
    }
    if (home_.ok()) {
      const Displacements home = home_.l_mm;
      consider(
          Mistake::mechanism, "commands count from home, not from each drive's zero",
          distance({.solver = solver_,
                    .drives = [home](const Displacements& l) { return Displacements(l - home); }},
                   commands_, targets_)
              .whole_mm,
          now_mm, kFit, bound_mm);
    }
    scaled_commands(kFit, bound_mm);
    for (const double unit : kLengthUnits) {
      Poses right = targets_;
      for (Pose& p : right) p = {p.x_mm / unit, p.y_mm / unit, p.phi_rad};
      consider(Mistake::scale, "target x and y " + unit_words(unit) + ", measured ones too",
               distance({solver_}, commands_, right).whole_mm, now_mm, kFit, bound_mm);
    }
    for (const double slope : {rad_from_deg(1), deg_from_rad(1)}) {
      Poses right = targets_;
      for (Pose& p : right) p.phi_rad /= slope;
      consider(Mistake::radians,
               slope < 1 ? "all orientations are radians where degrees are due"
                         : "all orientations were converted from degrees twice",
               distance({solver_}, commands_, right).whole_mm, now_mm, kFit, bound_mm);
    }
    if (of_targets_.scatter_mm < kNothingMm) {  // an R is a joint zero of all drives
      const Displacements& zero = of_targets_.zero_mm;
      const bool equal = is_prr(solver_) && zero.maxCoeff() - zero.minCoeff() < kNothingMm;
      consider(Mistake::mechanism,
               equal ? printed("commands are those of R = %.6g mm (or of joint zeros as far off)",
                               geometry_of(solver_.machine()).chains[0].R_mm + zero.mean())
                     : printed("commands count from other joint zeros: by %.4g, %.4g, %.4g mm",
                               zero[0], zero[1], zero[2]),
               of_targets_.scatter_mm, now_mm, kFit, bound_mm);
    }
  }

  /// c = k l(T) + const for all drives alike: metres, inches, another lead.
  void scaled_commands(const char* relation, double bound_mm) {
    Displacements mean_c = Displacements::Zero(), mean_l = Displacements::Zero();
    std::vector<std::pair<Displacements, Displacements>> rows;
    for (std::size_t k = 0; k < commands_.size(); ++k) {
      if (const Displaced l = displacements_at({solver_}, targets_[k]))
        rows.emplace_back(commands_[k], *l);
    }
    const auto n = static_cast<double>(rows.size());
    for (const auto& [c, l] : rows) {
      mean_c += c / n;
      mean_l += l / n;
    }
    double cl = 0, ll = 0;
    for (const auto& [c, l] : rows) {
      cl += (c - mean_c).dot(l - mean_l);
      ll += (l - mean_l).squaredNorm();
    }
    if (!(ll > 0) || !(cl > 0) || std::abs(cl / ll - 1) < kMostScaled) return;
    const double scale = cl / ll;
    consider(
        Mistake::scale, "commands " + unit_words(scale),
        distance({.solver = solver_,
                  .drives = [scale](const Displacements& l) { return Displacements(scale * l); }},
                 commands_, targets_)
                .scatter_mm /
            scale,
        of_targets_.whole_mm, relation, bound_mm);
  }

  /// Commands carry no noise: one other length that explains all of them is the plan's.
  void other_lengths() {
    const double now_mm = of_targets_.whole_mm;
    if (!(now_mm > kNothingMm) || !is_prr(solver_)) return;
    const Geometry geometry = geometry_of(solver_.machine());
    for (const Length& length : kLengths) {
      constexpr int kSteps = 6;
      constexpr double kSmallMm = 1e-3;
      double by_mm = 0, left_mm = INFINITY;
      for (int step = 0; step < kSteps; ++step) {
        double rs = 0, ss = 0;
        for (std::size_t k = 0; k < commands_.size(); ++k) {
          const Displaced at = displacements_at({longer(geometry, length, by_mm)}, targets_[k]);
          const Displaced next =
              displacements_at({longer(geometry, length, by_mm + kSmallMm)}, targets_[k]);
          if (!at || !next) continue;
          const Displacements slope = (*next - *at) / kSmallMm;
          rs += slope.dot(commands_[k] - *at);
          ss += slope.squaredNorm();
        }
        if (!(ss > 0)) break;
        const double most = 0.5 * (geometry.chains[0].*(length.of) + by_mm);
        by_mm += std::clamp(rs / ss, -most, most);
        left_mm = distance({longer(geometry, length, by_mm)}, commands_, targets_).whole_mm;
      }
      if (std::abs(by_mm) < kOtherLengthMm) continue;
      const double is = geometry.chains[0].*(length.of);
      consider(
          Mistake::mechanism,
          printed("commands are those of %s = %.6g mm, not of %.6g", length.name, is + by_mm, is),
          left_mm, now_mm, "commands fit the inverse kinematics of the targets", kNothingMm);
      if (left_mm < kExactMm && !fitted_.empty() &&
          fitted_.back().suspicion.kind == Mistake::mechanism)
        fitted_.back().left_mm = left_mm;  // commands carry no noise: nothing fits as well
    }
  }

  /// Shifted by so many rows most poses would be others', and enough are left: a plan that is
  /// walked again has the same targets some rows later.
  [[nodiscard]] bool moves_targets(int by) const {
    const std::vector<double> off = distances_mm(targets_, targets_, by);
    const auto others = std::ranges::count_if(off, [this](double mm) { return mm > other_mm_; });
    return others >= kFewestScreened && 2 * others > std::ssize(off) &&
           2 * off.size() >= targets_.size();
  }

  void shifted_rows() {
    const double now_mm = lie_.off_mm;
    for (int by = -kMostRows; by <= kMostRows; ++by) {
      if (by == 0 || !moves_targets(by)) continue;
      const std::string rows = rows_in_words(by);
      const auto stand = [&](const char* what, bool late) {
        return std::string(what) + " stand " + rows + (late ? " too late" : " too early");
      };
      const double poses_mm =
          robust_sigma(distances_mm(targets_, measured_, by), kNearlyAll, kNearlyAllOfNormal);
      const bool targets = of_measured_.whole_mm < of_targets_.whole_mm;
      consider(Mistake::shifted_rows,
               targets ? stand("targets", by < 0) : stand("measured poses", by > 0), poses_mm,
               now_mm, kLie, most_mm_);
      if (poses_mm * kFarBetter < now_mm || of_targets_.whole_mm < kNothingMm) continue;
      consider(Mistake::shifted_rows, stand("commands", by < 0),
               distance({solver_}, commands_, targets_, by).whole_mm, of_targets_.whole_mm,
               "commands fit the inverse kinematics of the targets", most_mm_);
    }
  }

  /// Too many of the readings lie apart to be single wrong ones, which a quantile of few readings
  /// meets as well: two of six.
  [[nodiscard]] bool many_lie_apart(bool by_commands) const {
    std::vector<double> x, y;
    for (std::size_t k = 0; k < measured_.size(); ++k) {
      x.push_back(measured_[k].x_mm - targets_[k].x_mm);
      y.push_back(measured_[k].y_mm - targets_[k].y_mm);
    }
    const Complex middle(median(x), median(y));
    std::ptrdiff_t beyond = 0;
    for (std::size_t k = 0; k < measured_.size(); ++k) {
      double off_mm = std::abs(Complex(x[k], y[k]) - middle);
      if (by_commands) {
        const Displaced l = displacements_at({solver_}, targets_[k]);
        off_mm = l ? (commands_[k] - *l).cwiseAbs().maxCoeff() : INFINITY;
      }
      if (off_mm > (by_commands ? sound_mm_ : most_mm_)) ++beyond;
    }
    return static_cast<double>(beyond) > kManyApart * static_cast<double>(measured_.size());
  }

  /// The first word of what is wrong: "commands", "target".
  static std::string column_of(const Suspicion& s) { return s.what.substr(0, s.what.find(' ')); }

  std::vector<Suspicion> chosen(bool robot_lies, bool commands_lie) {
    std::stable_sort(
        fitted_.begin(), fitted_.end(),
        [](const FittedMistake& a, const FittedMistake& b) { return a.left_mm < b.left_mm; });
    std::vector<Suspicion> all;
    for (const FittedMistake& f : fitted_) {
      if (f.left_mm > kAlike * fitted_.front().left_mm || all.size() == 2) break;
      const bool named = std::any_of(all.begin(), all.end(), [&](const Suspicion& s) {
        return s.kind == f.suspicion.kind && column_of(s) == column_of(f.suspicion);
      });
      if (!named) all.push_back(f.suspicion);
    }
    const bool wild = lie_.place.left_mm > most_mm_ && robot_lies;
    if (all.empty() && (commands_lie || wild) && many_lie_apart(commands_lie)) {
      all.push_back({Mistake::mechanism,
                     commands_lie ? "the commands do not belong to this mechanism"
                                  : "the measured poses belong neither to the targets nor to the "
                                    "commands",
                     printed("commands are %.2g mm off the inverse kinematics of the readings and "
                             "%.2g mm off that of the targets",
                             of_measured_.whole_mm, of_targets_.whole_mm)});
    }
    return all;
  }

  Campaign campaign_;
  MachineSolver solver_;
  Commands commands_;
  Poses targets_, measured_;
  InverseResult home_;
  double spread_mm_ = 0;
  double other_mm_ = kMostShiftedMm;  // targets farther apart are two places
  double sound_mm_ = kLeastMm;        // what commands of a sound robot are off at the most
  double most_mm_ = kMostShiftedMm;   // and poses
  Distance of_measured_, of_targets_;
  Lie lie_;
  std::vector<FittedMistake> fitted_;
};

}  // namespace

Campaign completed(const Campaign& campaign) {
  Campaign all = campaign;
  const Machine& machine = campaign.machine;
  for (Reading& r : all.readings) {
    if (!r.measured) continue;
    const Eigen::Vector3d target = r.target.vector();
    Eigen::Vector3d measured = r.measured->vector();
    for (int c = 0; c < 3; ++c) {
      const bool known = machine.measured[static_cast<std::size_t>(c)];
      if (!known || c >= machine.kind->n_chains) measured[c] = target[c];
    }
    r.measured = Pose::from(measured);
  }
  return all;
}

std::vector<Suspicion> gross_mistakes_of_all(const Campaign& campaign, bool last_resort) {
  Search search(completed(campaign));
  return search.enough() ? search.found(last_resort) : std::vector<Suspicion>{};
}

std::optional<FrameMove> fitted_frame(const Campaign& as_measured) {
  const Campaign campaign = completed(as_measured);
  const bool turns = campaign.machine.measured[2] && campaign.machine.kind->n_chains == kChains;
  Poses targets, measured;
  for (const Reading& r : campaign.readings) {
    if (!r.measured) continue;
    targets.push_back(r.target);
    measured.push_back(*r.measured);
  }
  if (targets.size() < static_cast<std::size_t>(kFewestScreened)) return std::nullopt;
  const Lie free = lie(targets, measured);
  for (const LiePart& part : parts_of(free, "")) {
    if (part.kind != Mistake::frame_turned && part.kind != Mistake::frame_shifted)
      return std::nullopt;
  }
  if (turns && std::abs(wrapped(free.angle.offset_rad - free.place.turn_rad)) > kMostTurnedRad)
    return std::nullopt;  // positions alone are turned
  const Similarity rigid = similarity(points_of(targets, measured), false, true);
  if (rigid.left_mm > kSimilarShare * std::max(free.width_mm, kNarrowMm)) return std::nullopt;
  return FrameMove{rigid.turn_rad, rigid.shift_mm.real(), rigid.shift_mm.imag()};
}

Pose in_robot_frame(const FrameMove& frame, const Pose& pose) {
  const Complex at = (place_of(pose) - Complex(frame.shift_x_mm, frame.shift_y_mm)) *
                     std::polar(1.0, -frame.turn_rad);
  return {at.real(), at.imag(), pose.phi_rad - frame.turn_rad};
}

}  // namespace trammel
