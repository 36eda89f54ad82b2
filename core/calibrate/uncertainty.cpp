#include "core/calibrate/uncertainty.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "core/calibrate/map_uncertainty.hpp"
#include "core/calibrate/model_uncertainty.hpp"
#include "core/error.hpp"
#include "core/judge/range.hpp"
#include "core/statistics/limits.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

/// k = 2 of a coordinate of place, both alike where the machine has both, and of phi.
Expanded expanded(const NominalMachine& machine, const Eigen::Vector3d& variance) {
  const double places = std::min(machine.machine().kind->n_chains, 2);
  return {.U_mm = 2 * std::sqrt(std::max((variance[0] + variance[1]) / places, 0.0)),
          .U_rad = 2 * std::sqrt(std::max(variance[2], 0.0))};
}

/// The conditions under which the corrected robot goes to the target of `reading`.
Conditions corrected(const Correction& correction, const NominalMachine& machine,
                     const Reading& reading) {
  const InverseResult at = commanded(correction, machine, move_of(reading));
  if (!at.ok()) {
    throw InputError({.what = "the corrected robot cannot reach a target",
                      .where = {.point = "seq " + std::to_string(reading.seq)}});
  }
  Conditions conditions = reading.conditions;
  conditions.cmd_mm = at.l_mm;
  return conditions;
}

/// J_V of the nominal robot at the target.
Eigen::Matrix3d jacobian_of(const NominalMachine& machine, const Reading& reading) {
  if (machine.chains(reading.target).ok()) return machine.look(reading.target).J_V;
  throw InputError({.what = "the nominal robot cannot reach a target",
                    .where = {.point = "seq " + std::to_string(reading.seq)}});
}

Eigen::Vector3d map_variance(const MapUncertainty& known, const NominalMachine& machine,
                             const Reading& reading) {
  return pose_variance(known, {reading.target.x_mm, reading.target.y_mm},
                       jacobian_of(machine, reading));
}

/// A stored model does not say which coordinates were measured: the campaign does.
RobotModel as_measured(RobotModel model, const NominalMachine& machine) {
  model.nominal.measured = machine.machine().measured;
  return model;
}

PointUncertainty of_model(const Correction& correction, const RobotModel& model,
                          const NominalMachine& machine, std::span<const Reading> fitted,
                          const TrackerSigma& sigma) {
  const ModelUncertainty known = model_uncertainty(as_measured(model, machine), fitted, sigma);
  return {"the covariance of the fitted model and its lack of fit", [=](const Reading& reading) {
            const Conditions at = corrected(correction, machine, reading);
            return expanded(machine, pose_covariance(known, at).diagonal());
          }};
}

std::optional<PointUncertainty> of_map(const MapCorrection& c, const NominalMachine& machine,
                                       std::span<const Reading> fitted, const TrackerSigma& sigma) {
  if (fitted.size() > kMostFieldSamples) return std::nullopt;
  const std::vector<Reading> rows = without_shifts(fitted, c.epochs);
  const MapUncertainty known =
      map_uncertainty(c.map, machine, joint_samples(machine, rows), rows, sigma);
  return PointUncertainty{
      "what the map misses of a random field like its samples, and what no place explains",
      [=](const Reading& reading) {
        return expanded(machine, map_variance(known, machine, reading));
      }};
}

std::optional<PointUncertainty> of_hybrid(const Correction& correction, const HybridCorrection& h,
                                          const NominalMachine& machine,
                                          std::span<const Reading> fitted,
                                          const TrackerSigma& sigma) {
  if (fitted.size() > kMostFieldSamples) return std::nullopt;
  ModelUncertainty model = model_uncertainty(as_measured(h.model, machine), fitted, sigma);
  model.lack_xy_mm = model.lack_phi_rad = 0;  // the map takes it, or counts it as unexplained
  const MapUncertainty left =
      map_uncertainty(h.left, machine, samples_left(h.model, fitted), fitted, sigma);
  return PointUncertainty{
      "the covariance of the fitted model, and what the map misses of what it leaves",
      [=](const Reading& reading) {
        const Conditions at = corrected(correction, machine, reading);
        return expanded(
            machine, pose_covariance(model, at).diagonal() + map_variance(left, machine, reading));
      }};
}

/// One coordinate of a held-out error, and the standard uncertainty that was expected of it.
struct Entry {
  int seq = 0;
  double error = 0, own = 0;

  /// Times its own uncertainty at which the coordinate is k = 2 away, the noise aside.
  [[nodiscard]] double factor(double sigma) const {
    return std::sqrt(std::max(0.0, error * error / 4 - sigma * sigma)) / own;
  }
};

/// How held-out errors change an expected uncertainty u: to sqrt(factor^2 u^2 + more^2).
struct Change {
  double factor = 1, more = 0;
};

/// Coordinates of one kind, place or phi.
class Kind {
 public:
  Kind(double sigma, std::vector<Entry> entries) : sigma_(sigma), entries_(std::move(entries)) {
    std::ranges::stable_sort(entries_, {}, &Entry::seq);
    for (const Entry& e : entries_) {
      own2_ += e.own * e.own;
      seen2_ += e.error * e.error;
      if (e.own > 0) factors_.push_back(e.factor(sigma_));
    }
    std::ranges::sort(factors_);
  }

  /// By all that are not of `seq`.
  [[nodiscard]] Change without(int seq) const {
    double own2 = own2_, seen2 = seen2_;
    std::vector<double> left_out;
    for (const Entry& e : std::ranges::equal_range(entries_, seq, {}, &Entry::seq)) {
      own2 -= e.own * e.own;
      seen2 -= e.error * e.error;
      if (e.own > 0) left_out.push_back(e.factor(sigma_));
    }
    const auto n = static_cast<double>(factors_.size() - left_out.size());
    if (n < 2) return {};
    if (own2 / n > sigma_ * sigma_) {
      std::size_t at = static_cast<std::size_t>(std::min(n, std::ceil(kWithin * (n + 1)))) - 1;
      std::ranges::sort(left_out);  // each that stands before it moves it on by one
      for (const double factor : left_out) at += factor <= factors_[at] ? 1U : 0U;
      return {.factor = factors_[at]};
    }
    const double more2 = std::max(0.0, (seen2 - own2) / n - sigma_ * sigma_);
    const double u2 = own2 / n + more2, share = u2 / (u2 + sigma_ * sigma_);
    const double t = student_limit(1 - kWithin, std::max(kLeastDegrees, n * share * share)) / 2;
    return {.factor = t, .more = t * std::sqrt(more2)};
  }

 private:
  static constexpr double kWithin = 0.9545;   // of a normal distribution, k = 2
  static constexpr double kLeastDegrees = 5;  // below it t says no more than that little is known
  double sigma_, own2_ = 0, seen2_ = 0;
  std::vector<Entry> entries_;   // by seq
  std::vector<double> factors_;  // of those that expect something, rising
};

std::string words_of(const Change& change, double unit, const char* name) {
  char text[100];
  if (change.more > 0) {
    std::snprintf(text, sizeof text, "times %.2f and %.4f %s more", change.factor,
                  unit * change.more, name);
  } else {
    std::snprintf(text, sizeof text, "times %.2f", change.factor);
  }
  return text;
}

double changed(double U, const Change& by) { return std::hypot(by.factor * U, 2 * by.more); }

FittedRange range_of(std::span<const HeldOut> held_out) {
  std::vector<Reading> readings;
  for (const HeldOut& h : held_out) readings.push_back(*h.reading);
  return fitted_range(readings);
}

}  // namespace

std::optional<PointUncertainty> own_uncertainty(const Correction& correction,
                                                const NominalMachine& machine,
                                                std::span<const Reading> fitted,
                                                const TrackerSigma& sigma) {
  if (const auto* g = std::get_if<GeometryCorrection>(&correction)) {
    RobotModel model = nominal_model(machine.machine());
    set_geometry(model.machine, g->geometry);
    return of_model(correction, model, machine, fitted, sigma);
  }
  if (const auto* m = std::get_if<ModelCorrection>(&correction)) {
    return of_model(correction, m->model, machine, fitted, sigma);
  }
  if (const auto* m = std::get_if<MapCorrection>(&correction)) {
    return of_map(*m, machine, fitted, sigma);
  }
  if (const auto* h = std::get_if<HybridCorrection>(&correction)) {
    return of_hybrid(correction, *h, machine, fitted, sigma);
  }
  return std::nullopt;
}

PointUncertainty calibrated(const PointUncertainty& own, std::span<const HeldOut> held_out,
                            const TrackerSigma& sigma, bool may_narrow) {
  if (held_out.size() < kFewestHeldOut) return own;
  std::vector<Entry> places, orientations;
  for (const HeldOut& h : held_out) {
    const Expanded U = own.of(*h.reading);
    const int seq = h.reading->seq;
    if (h.measured[0]) places.push_back({seq, h.error.x_mm, U.U_mm / 2});
    if (h.measured[1]) places.push_back({seq, h.error.y_mm, U.U_mm / 2});
    if (h.measured[2]) orientations.push_back({seq, h.error.phi_rad, U.U_rad / 2});
  }
  const bool turns = !orientations.empty();
  const Kind place(sigma.xy_mm, std::move(places)), phi(sigma.phi_rad, std::move(orientations));
  constexpr int kNone = -1;
  std::string basis = own.basis + "; by " + std::to_string(held_out.size()) +
                      " held-out points of place " + words_of(place.without(kNone), 1, "mm");
  if (turns) basis += ", of phi " + words_of(phi.without(kNone), deg_from_rad(1), "deg");
  const bool narrows = place.without(kNone).factor < 1 || (turns && phi.without(kNone).factor < 1);
  if (narrows) {
    basis += may_narrow ? " (beyond their hull never less than by itself)"
                        : " (never less than by itself)";
  }
  return {basis, [inner = own.of, place, phi, may_narrow,
                  seen = range_of(held_out)](const Reading& reading) {
            const Expanded U = inner(reading);
            const bool is_seen = may_narrow && seen.why_outside(reading.target).empty();
            const auto of = [&](const Kind& kind) {
              Change change = kind.without(reading.seq);
              if (!is_seen) change.factor = std::max(1.0, change.factor);
              return change;
            };
            return Expanded{.U_mm = changed(U.U_mm, of(place)), .U_rad = changed(U.U_rad, of(phi))};
          }};
}

PointUncertainty held_out_uncertainty(std::span<const HeldOut> held_out, const std::string& whence,
                                      const TrackerSigma& sigma) {
  TRAMMEL_ASSERT(held_out.size() >= 2);
  struct Squares {
    double place = 0, phi = 0, n = 0;
    void add(const Squares& s, double times) {
      place += times * s.place;
      phi += times * s.phi;
      n += times * s.n;
    }
  };
  Squares all;
  std::map<int, Squares> of_seq;
  for (const HeldOut& h : held_out) {
    const Pose& e = h.error;
    const double x2 = h.measured[0] ? e.x_mm * e.x_mm : 0, y2 = h.measured[1] ? e.y_mm * e.y_mm : 0;
    const int places = std::max(1, h.measured[0] + h.measured[1]);
    const Squares one{(x2 + y2) / places, h.measured[2] ? e.phi_rad * e.phi_rad : 0, 1};
    all.add(one, 1);
    of_seq[h.reading->seq].add(one, 1);
  }
  return {"the errors of " + whence + ", their noise removed (the same at every point)",
          [all, of_seq, sigma](const Reading& reading) {
            Squares others = all;
            if (const auto own = of_seq.find(reading.seq); own != of_seq.end())
              others.add(own->second, -1);
            const auto beyond = [&](double squares, double noise) {
              return 2 * std::sqrt(std::max(0.0, squares / others.n - noise * noise));
            };
            return Expanded{.U_mm = beyond(others.place, sigma.xy_mm),
                            .U_rad = beyond(others.phi, sigma.phi_rad)};
          }};
}

}  // namespace trammel
