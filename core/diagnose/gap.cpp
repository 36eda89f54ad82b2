#include "core/diagnose/gap.hpp"

#include <algorithm>
#include <cmath>

#include "core/model/predictor.hpp"
#include "core/statistics/random.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

constexpr int kBootstrap = 1000;

/// Squared deviations of each reading: x^2 + y^2 in mm^2, of those that are measured, and phi^2 in
/// rad^2.
struct Squares {
  std::vector<double> xy, phi;
  double share = 0.5;                              // of one coordinate of xy
  Eigen::Vector3d each = Eigen::Vector3d::Zero();  // sums
};

Squares squares(const RobotModel& model, std::span<const Reading> readings) {
  Squares s;
  const Coordinates& measured = model.nominal.measured;
  s.share = measured[0] && measured[1] ? 0.5 : 1;
  const Predictor expected(model);
  for (const Reading& r : readings) {
    const Prediction at = expected.predict(r.conditions);
    if (!at.ok() || !r.measured) continue;
    Eigen::Vector3d d = r.measured->vector() - at.pose.vector();
    for (int c = 0; c < 3; ++c) {
      if (!measured[static_cast<std::size_t>(c)]) d[c] = 0;
    }
    s.each += d.cwiseAbs2();
    s.xy.push_back(d.head<2>().squaredNorm());
    if (measured[2]) s.phi.push_back(d[2] * d[2]);
  }
  return s;
}

double mean(const std::vector<double>& v) {
  double sum = 0;
  for (const double x : v) sum += x;
  return sum / static_cast<double>(v.size());
}

std::optional<double> rms_xy(const Squares& s) {
  if (s.xy.empty()) return std::nullopt;
  return std::sqrt(s.share * mean(s.xy));
}

std::optional<Eigen::Vector3d> rms_each(const Squares& s) {
  if (s.xy.empty()) return std::nullopt;
  return (s.each / static_cast<double>(s.xy.size())).cwiseSqrt();
}

std::optional<double> rms_deg(const Squares& s) {
  if (s.phi.empty()) return std::nullopt;
  return deg_from_rad(std::sqrt(mean(s.phi)));
}

/// Of one coordinate of x and y, where their noise differs the root of its mean square.
double one_sigma_mm(const PoseSigma& sigma, const Coordinates& measured) {
  const auto& each = sigma.each;
  if (each[0] == each[1] || !measured[1]) return each[0];
  return measured[0] ? each.head<2>().norm() / std::sqrt(2.0) : each[1];
}

double closed(double before, double after, double noise_squared) {
  return 1 - std::max(0.0, after - noise_squared) / (before - noise_squared);
}

void interval(GapStep& step, const Squares& before, const Squares& after, double sigma_mm) {
  const double s2 = sigma_mm * sigma_mm, share = before.share;
  if (before.xy.empty() || share * mean(before.xy) <= s2) return;
  step.closed_share = closed(share * mean(before.xy), share * mean(after.xy), s2);
  std::vector<double> shares;
  Random random = Random::stream(1, "gap");
  const std::uint64_t n = before.xy.size();
  for (int b = 0; b < kBootstrap; ++b) {
    double was = 0, is = 0;
    for (std::uint64_t i = 0; i < n; ++i) {
      const auto pick = static_cast<std::size_t>(random.below(n));
      was += share * before.xy[pick] / static_cast<double>(n);
      is += share * after.xy[pick] / static_cast<double>(n);
    }
    if (was > s2) shares.push_back(closed(was, is, s2));
  }
  std::sort(shares.begin(), shares.end());
  if (shares.size() < kBootstrap / 2) return;
  step.closed_low = shares[shares.size() / 40];
  step.closed_high = shares[shares.size() - 1 - shares.size() / 40];
}

/// Each parameter with its standard deviation, where the readings know it by itself.
void add_parameters(GapStep& step, const GeometryFit& fit) {
  constexpr double kByItself = 1 - 1e-6;  // share of the parameter outside the null space
  step.parameters = fit.parameters;
  for (std::size_t k = 0; k < fit.parameters.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const bool known = fit.identified.directions.row(row).squaredNorm() > kByItself;
    step.std.push_back(
        known ? std::optional(fit.parameters[k].scale * std::sqrt(fit.covariance(row, row)))
              : std::nullopt);
  }
}

GapStep make_step(std::string name, const RobotModel& robot, std::span<const Reading> fitted,
                  std::span<const Reading> unseen, const RobotModel& nominal, double sigma_mm) {
  GapStep step;
  step.model = std::move(name);
  step.robot = robot;
  const Squares in = squares(robot, fitted), out = squares(robot, unseen);
  step.identify_rms_mm = rms_xy(in);
  step.validate_rms_mm = rms_xy(out);
  step.identify_rms_deg = rms_deg(in);
  step.validate_rms_deg = rms_deg(out);
  step.identify_rms = rms_each(in);
  step.validate_rms = rms_each(out);
  if (step.model != "nominal") {
    const bool judged = !out.xy.empty();
    interval(step, squares(nominal, judged ? unseen : fitted), judged ? out : in, sigma_mm);
  }
  return step;
}

}  // namespace

void measure_gap(const Campaign& campaign, std::span<const Reading> fitted, const GeometryFit& base,
                 Diagnosis& diagnosis) {
  std::vector<Reading> unseen, seen;  // as measured: a robust fit draws far readings in
  for (const Reading& r : campaign.readings) {
    if (r.set == ReadingSet::validate && r.measured) unseen.push_back(r);
    if (std::ranges::find(fitted, r.seq, &Reading::seq) != fitted.end()) seen.push_back(r);
  }
  const PoseSigma sigma = diagnosis.noise.sigma();
  const double sigma_mm = one_sigma_mm(sigma, base.model.nominal.measured);
  const RobotModel nominal = nominal_model(base.model.nominal);
  diagnosis.gap.push_back(make_step("nominal", nominal, seen, unseen, nominal, sigma_mm));
  const auto step = [&](std::string name, const GeometryFit& fit) {
    GapStep made = make_step(std::move(name), fit.model, seen, unseen, nominal, sigma_mm);
    add_parameters(made, fit);
    return made;
  };
  // Each effect of `named` with its values in `model`, the largest first; `last`: the fit of all.
  const auto chain = [&](const std::vector<NamedEffect>& named, const RobotModel& model,
                         const GeometryFit* last, std::vector<GapStep>& gap) {
    std::vector<const NamedEffect*> order;
    for (const NamedEffect& e : named) {
      if (e.name != "outlier_readings") order.push_back(&e);
    }
    std::stable_sort(order.begin(), order.end(), [](const NamedEffect* a, const NamedEffect* b) {
      return a->share_of_gap > b->share_of_gap;
    });
    GeometryFit fit = base;
    for (const NamedEffect* e : order) {
      RobotModel start = fit.model;
      for (const ActiveEffect& active : model.effects) {
        if (active.effect->name == e->name) start.effects.push_back(active);
      }
      const bool all = start.effects.size() == model.effects.size();
      fit = all && last != nullptr
                ? *last
                : fit_geometry(start, fitted, sigma, {.correlation = diagnosis.noise.correlation});
      gap.push_back(step("+" + e->name, fit));
    }
  };
  diagnosis.gap.push_back(step("geometry", base));
  chain(diagnosis.effects, diagnosis.fit.model, &diagnosis.fit, diagnosis.gap);
  chain(diagnosis.tried, diagnosis.tried_model, nullptr, diagnosis.gap_tried);
}

}  // namespace trammel
