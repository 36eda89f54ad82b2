#include "app/report/job_uncertainty.hpp"

#include <fmt/format.h>

#include <cmath>

#include "app/job/held_out.hpp"
#include "app/job/run.hpp"
#include "app/report/methods.hpp"
#include "core/error.hpp"
#include "core/judge/deviation.hpp"
#include "core/plane/blocks.hpp"

namespace trammel::report {

namespace {

constexpr int kBlocks = 6;

CrossValidated cross_validated(const store::Job& job, const Campaign& campaign,
                               const std::vector<Reading>& fitted) {
  std::vector<Place> places;
  for (const Reading& r : fitted) places.push_back({r.target.x_mm, r.target.y_mm});
  const job::Stage& stage = job::find_stage(job.data.stage);
  const job::Json parameters = job::completed(stage, job::Json::parse(job.data.parameters_json));
  const auto fit = [&](const Campaign& training) {
    return stage.run(job::as_asked(training, parameters), parameters).correction;
  };
  const std::vector<int> block = spatial_blocks(places, kBlocks);
  CrossValidated found{
      .blocks = kBlocks, .after = job::held_out_poses(fit, campaign, fitted, block), .outside = {}};
  std::vector<FittedRange> others;  // what each block was predicted from
  for (int b = 0; b < kBlocks; ++b) {
    std::vector<Reading> rest;
    for (std::size_t k = 0; k < fitted.size(); ++k) {
      if (block[k] != b) rest.push_back(fitted[k]);
    }
    others.push_back(fitted_range(rest));
  }
  for (std::size_t k = 0; k < fitted.size(); ++k) {
    found.outside.push_back(
        others[static_cast<std::size_t>(block[k])].why_outside(fitted[k].target));
  }
  return found;
}

struct HeldOutErrors {
  std::vector<HeldOut> in_range;
  std::string whence;
  bool any = false;
};

/// Of the baseline walks.
HeldOutErrors held_out_of(const Measured& measured, const store::Job& job,
                          const FittedRange& range) {
  HeldOutErrors found;
  const Seen seen = seen_by(measured, job);
  for (const Group& group : baseline_groups(measured)) {
    const Paired unseen = of_standing(paired(measured, group, job), seen, Standing::unseen);
    if (unseen.pairs.empty()) continue;
    found.any = true;
    found.whence += (found.whence.empty() ? "" : ", ") + group.walk->session.name;
    for (const Pair& pair : unseen.pairs) {
      const Reading& r = pair.before->reading;
      if (!range.why_outside(r.target).empty()) continue;
      found.in_range.push_back({.reading = &r,
                                .error = Pose::from(pose_difference(pair.after, r.target)),
                                .measured = measured.campaign.machine.measured});
    }
  }
  return found;
}

std::optional<double> rms_mm(const PointUncertainty& of, const std::vector<HeldOut>& points) {
  if (points.empty()) return std::nullopt;
  double squares = 0;
  for (const HeldOut& point : points) squares += std::pow(of.of(*point.reading).U_mm / 2, 2);
  return std::sqrt(squares / static_cast<double>(points.size()));
}

}  // namespace

JobUncertainty uncertainty_of(store::Connection& connection, const Measured& measured,
                              const store::Job& job, const std::optional<NoiseLevel>& noise) {
  const Campaign trained = job::trained_on(connection, job);
  JobUncertainty found;
  found.fitted = job::identify_rows(trained);
  found.range = fitted_range(found.fitted);
  HeldOutErrors held_out = held_out_of(measured, job, found.range);
  if (!held_out.any) {
    try {
      found.cross_validated = cross_validated(job, trained, found.fitted);
      held_out.whence = fmt::format("{} spatial blocks", kBlocks);
      for (std::size_t k = 0; k < found.fitted.size(); ++k) {
        const Reading& r = found.fitted[k];
        if (!found.cross_validated->outside[k].empty()) continue;
        held_out.in_range.push_back(
            {.reading = &r,
             .error = Pose::from(pose_difference(found.cross_validated->after[k], r.target)),
             .measured = trained.machine.measured});
      }
    } catch (const InputError& error) {
      found.why_not_validated = error.text().what;
    }
  }
  if (!noise) return found;
  const Correction correction = job::correction_of(job.data.result_json);
  if (const auto own =
          own_uncertainty(correction, measured.campaign.machine, found.fitted, noise->sigma)) {
    found.of = calibrated(*own, held_out.in_range, noise->sigma, held_out.any);
  } else if (held_out.in_range.size() >= kFewestHeldOut) {
    found.of = held_out_uncertainty(held_out.in_range,
                                    fmt::format("held-out points in range ({})", held_out.whence),
                                    noise->sigma);
  }
  if (found.of) found.rms_mm = rms_mm(*found.of, held_out.in_range);
  return found;
}

}  // namespace trammel::report
