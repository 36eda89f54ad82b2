#include "core/diagnose/noise_floor.hpp"

#include <algorithm>
#include <cmath>

#include "core/diagnose/naming.hpp"
#include "core/diagnose/noise.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

constexpr double kAssumedXyMm = 0.010;  // where neither tracker nor repeats say: only a first guess
constexpr double kAssumedPhiRad = rad_from_deg(0.01);
constexpr double kLarge = 10;  // chi^2 over its degrees of freedom

/// A linearisation, and the catalogue's signals in it.
struct Around {
  ResidualSpace space;
  Library library;
};

/// Base and catalogue as the noise is judged by: around the exact fit of what is found first where
/// that is large. Second order of a lead 1.6 % off is several sigmas at the ends of the rails, and
/// no single bad readings.
Around around_what_is_large(Work& w) {
  Naming n;
  const bool large = w.base.chi2 > kLarge * w.base.dof;
  if (!large || !search_on_exact_model(w, n)) return {w.space, w.library};
  return {std::move(n.space), std::move(n.library)};
}

/// Two axes are read by an instrument each: y has a noise of its own where its residuals are not of
/// the size of x's beyond chance. True when that changed.
bool settle_axes(Work& w, const NoiseRatio& ratio) {
  if (!w.space.machine.kind->has_point_platform()) return false;
  if (!other_size(ratio.y / ratio.x, ratio.y_dof, ratio.x_dof)) return false;
  NoiseFloor& noise = w.out.noise;
  noise.used.xy_mm *= ratio.x;
  noise.y_over_x *= ratio.y / ratio.x;
  noise.rescaled = noise.source != NoiseSource::residuals;
  fit_base(w);
  return true;
}

}  // namespace

void first_noise(Work& w) {
  NoiseFloor& noise = w.out.noise;
  noise.repeats = pooled_noise(w.campaign.readings, w.campaign.machine.measured);
  if (w.campaign.tracker ||
      (noise.repeats && noise.repeats->degrees_of_freedom >= kEnoughRepeats)) {
    const NoiseLevel level = noise_level(w.campaign);
    noise.stated = level.stated.value_or(TrackerSigma{});
    noise.used = level.sigma;
    noise.degrees_of_freedom = level.degrees_of_freedom;
    noise.source =
        level.source == NoiseLevel::Source::tracker ? NoiseSource::tracker : NoiseSource::repeats;
    if (level.doubted) w.out.notes.push_back(level.words);
  } else {
    noise.used = {kAssumedXyMm, kAssumedPhiRad};
    noise.source = NoiseSource::residuals;
    w.out.notes.push_back(
        "no sigma is stated and there are too few repeats: the noise is what base and catalogue "
        "leave, so structure "
        "that looks like noise can't be seen");
  }
  noise.first = noise.used;
}

void settle_noise(Work& w) {
  for (int round = 0; round < 3; ++round) {
    const Around at = around_what_is_large(w);
    const NoiseRatio ratio = noise_ratio(at.space, at.library.signals);
    const bool unknown = w.out.noise.source == NoiseSource::residuals;
    const int repeats = w.out.noise.degrees_of_freedom;
    if (settle_axes(w, ratio)) continue;
    const bool xy = unknown || other_size(ratio.xy, ratio.xy_dof, 2 * repeats);
    const bool phi = unknown || other_size(ratio.phi, ratio.phi_dof, repeats);
    if (!xy && !phi) return;
    if (xy) w.out.noise.used.xy_mm *= ratio.xy;
    if (phi) w.out.noise.used.phi_rad *= ratio.phi;
    w.out.noise.rescaled = !unknown;
    fit_base(w);
  }
}

std::optional<Finding> unsupported_noise(const Work& w) {
  constexpr double kAsLarge = 3;  // repeats of one degree of freedom are as small by chance in a
                                  // quarter of campaigns, of ten in none
  const NoiseFloor& noise = w.out.noise;
  if (!noise.rescaled) return std::nullopt;
  const auto times = [&](double TrackerSigma::*part) {
    const bool supported =
        noise.repeats && kAsLarge * (noise.repeats->sigma.*part) > noise.used.*part;
    return noise.first.*part > 0 && !supported ? noise.used.*part / (noise.first.*part) : 0;
  };
  const double most = std::max(times(&TrackerSigma::xy_mm), times(&TrackerSigma::phi_rad));
  if (most < kMuchLarger) return std::nullopt;
  return Finding{"all readings",
                 "what is left is " + text_of(most) + " times the noise that " +
                     (noise.source == NoiseSource::repeats ? "repeats show" : "is stated") +
                     ", and no target that was approached again repeats as badly: single places, "
                     "or sigma_mm, are wrong",
                 0, 0, 0};
}

void settle_correlation(Work& w, bool known) {
  const auto space_with = [&](double rho) {
    return residual_space(
        fit_geometry(w.base.model, w.readings, w.out.noise.sigma(), {.correlation = rho}),
        w.readings, w.out.noise.sigma(), rho);
  };
  w.out.noise.correlation = noise_correlation(space_with, known);
  if (w.out.noise.correlation == 0) return;
  w.out.notes.emplace_back(
      w.out.noise.correlation > 0
          ? "the noise of successive readings is correlated: it is taken out before anything is "
            "tested"
          : "the noise of successive readings alternates: that is taken out before anything is "
            "tested");
  fit_base(w);
}

void settle_tails(Work& w) {
  const Around at_fit = around_what_is_large(w);
  auto tails = heavy_tails(at_fit.space, at_fit.library.signals);
  if (!tails) return;
  ResidualSpace left = at_fit.space;
  Eigen::MatrixXd all(left.rows(), left.Q.cols() + at_fit.library.signals.cols());
  all << left.Q, left.project(at_fit.library.signals);
  for (Eigen::Index j = left.Q.cols(); j < all.cols(); ++j) all.col(j).normalize();
  left.Q = orthonormal(all);
  left.residual = left.project(left.residual);
  const StructureTest structure = test_structure(left, dictionary(left),
                                                 {.replicates = w.options.replicates,
                                                  .level = w.options.false_alarm,
                                                  .seed = w.options.seed,
                                                  .threads = w.options.threads,
                                                  .exchange = true});
  if (structure.family_p <= w.options.false_alarm) return;
  NamedEffect bad;
  bad.name = "outlier_readings";
  bad.p = kFalseOutlier;
  for (std::size_t i = 0; i < tails->far.size(); ++i) {
    const std::size_t at = tails->far[i];
    const bool gross = std::ranges::find(tails->gross, at) != tails->gross.end();
    if (gross) {
      bad.seqs.push_back(w.readings[at].seq);
    } else {
      w.out.suspicious.push_back(
          {w.readings[at].seq, tails->sigmas[i], "the noise has heavy tails"});
    }
  }
  w.readings = std::move(tails->readings);
  for (auto it = tails->gross.rbegin(); it != tails->gross.rend(); ++it) {
    w.readings.erase(w.readings.begin() + static_cast<std::ptrdiff_t>(*it));
  }
  if (!bad.seqs.empty()) w.out.effects.push_back(std::move(bad));
  w.out.noise.robust = true;
  w.out.notes.emplace_back(
      "the noise has heavier tails than a normal distribution: the fit is robust, readings far off "
      "count as if they were " +
      text_of(kWinsor[static_cast<std::size_t>(w.space.coordinates())]) + " sigma away");
  fit_base(w);
}

void drop_certain_readings(Work& w, const std::vector<Suspicion>& found) {
  for (const Suspicion& s : found) {
    if (s.kind != Mistake::stale && s.kind != Mistake::missed && s.kind != Mistake::far) continue;
    const auto gone =
        std::erase_if(w.readings, [&](const Reading& r) { return r.seq == s.seqs.front(); });
    if (gone > 0) w.certain.push_back(s.seqs.front());
  }
}

void drop_bad_readings(Work& w) {
  NamedEffect bad;
  bad.name = "outlier_readings";
  bad.seqs = w.certain;
  for (int round = 0; round < 5 && !w.out.noise.robust; ++round) {
    const Around at = around_what_is_large(w);
    const auto places = bad_readings(at.space, at.library.signals);
    if (places.empty()) break;
    for (auto it = places.rbegin(); it != places.rend(); ++it) {
      bad.seqs.push_back(w.readings[*it].seq);
      w.readings.erase(w.readings.begin() + static_cast<std::ptrdiff_t>(*it));
    }
    fit_base(w);
  }
  if (bad.seqs.empty()) return;
  std::sort(bad.seqs.begin(), bad.seqs.end());
  bad.p = kFalseOutlier;
  w.out.effects.push_back(std::move(bad));
}

}  // namespace trammel
