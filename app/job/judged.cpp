#include "app/job/judged.hpp"

#include <fmt/format.h>

#include "app/job/fitted_range.hpp"
#include "app/terminal/decimals.hpp"
#include "core/error.hpp"
#include "core/judge/deviation.hpp"
#include "core/mechanism/nominal_machine.hpp"
#include "core/statistics/interval.hpp"
#include "core/statistics/summary.hpp"
#include "store/reading.hpp"

namespace trammel::job {

namespace {

/// What is counted together: the points of one set that stand alike.
struct Counted {
  ReadingSet set;
  Standing standing;
  std::vector<BeforeAfter> points = {};

  /// As tables and stored statistics call it.
  [[nodiscard]] const char* name() const {
    return standing == Standing::unknown_epoch ? kNewEpoch : store::name_of(set);
  }
};

std::vector<Counted> counted(const std::vector<Judged>& judged) {
  std::vector<Counted> all;
  for (const Standing standing : {Standing::fitted, Standing::unseen, Standing::unknown_epoch}) {
    for (const ReadingSet set : {ReadingSet::identify, ReadingSet::validate}) {
      Counted some{.set = set, .standing = standing};
      for (const Judged& j : judged) {
        if (j.standing == standing &&
            (j.set == ReadingSet::identify) == (set == ReadingSet::identify))
          some.points.push_back(j.point);
      }
      if (!some.points.empty()) all.push_back(std::move(some));
    }
  }
  return all;
}

store::Summary stored(const Summary& s) {
  return {.mean = s.mean, .max = s.max, .min = s.min, .p95 = s.p95, .n = static_cast<int>(s.n)};
}

}  // namespace

std::vector<Judged> judge(const Campaign& campaign, const JudgedBy& by,
                          const Correction& correction) {
  std::vector<Reading> measured;
  measured.reserve(campaign.readings.size());
  const NominalMachine machine(campaign.machine);
  for (const Reading& r : campaign.readings) {
    if (r.measured && (!by.leaves_out || machine.chains(*r.measured).ok())) measured.push_back(r);
  }
  const auto all_after = predicted_after(correction, campaign.machine, measured);
  std::vector<Judged> points;
  points.reserve(measured.size());
  for (std::size_t k = 0; k < measured.size(); ++k) {
    const Reading& r = measured[k];
    if (!all_after[k]) {
      throw InputError({.what = "the corrected robot cannot reach a target of the campaign",
                        .where = {.point = "seq " + std::to_string(r.seq)}});
    }
    if (by.of_no_walk.contains(r.seq)) continue;
    points.push_back({.seq = r.seq,
                      .set = r.set,
                      .epoch = r.conditions.epoch,
                      .standing = by.seen.standing(r),
                      .point = {r.target, machine.measured_else(*r.measured, r.target),
                                machine.measured_else(*all_after[k], r.target)}});
  }
  return points;
}

std::vector<store::Statistic> statistics(const Machine& machine,
                                         const std::vector<Judged>& judged) {
  std::vector<store::Statistic> all;
  for (const Counted& some : counted(judged)) {
    for (const Figure figure : figures_of(machine)) {
      const Errors errors = errors_in(figure, some.points);
      all.push_back({some.name(), figure == Figure::position_mm ? "position_mm" : "attitude_deg",
                     some.standing == Standing::fitted, stored(errors.summary_before),
                     stored(errors.summary_after)});
    }
  }
  return all;
}

Json improvements(const std::vector<Judged>& judged) {
  Json all = Json::array();
  for (const Counted& some : counted(judged)) {
    if (some.standing == Standing::unknown_epoch) continue;
    const Errors errors = errors_in(Figure::position_mm, some.points);
    const auto interval = improvement_interval_pct(errors.before, errors.after);
    if (!interval) continue;
    all.push_back(object_with("set", some.name(), "metric", "position_mm", "in_sample",
                              some.standing == Standing::fitted, "improvement_low_pct",
                              interval->low, "improvement_high_pct", interval->high));
  }
  return all;
}

std::vector<std::string> improvement_words(const Json& improvements) {
  std::vector<std::string> words;
  for (const Json& row : improvements) {
    words.push_back(fmt::format(
        "{} position: 95 % interval of the gain {:.1f} to {:.1f} % (t of the log ratio); `trammel "
        "assess --job` gives U",
        row["in_sample"].get<bool>() ? "in-sample" : "held-out",
        row["improvement_low_pct"].get<double>(), row["improvement_high_pct"].get<double>()));
  }
  return words;
}

std::vector<std::string> range_words(const std::vector<Judged>& judged) {
  std::vector<Reading> fitted;
  std::vector<Pose> held_out;
  for (const Judged& j : judged) {
    if (j.standing == Standing::fitted) fitted.emplace_back().target = j.point.target;
    if (j.standing == Standing::unseen) held_out.push_back(j.point.target);
  }
  if (fitted.empty()) return {};
  std::vector<std::string> words =
      extrapolation_words(trammel::fitted_range(fitted), held_out, "held-out point");
  for (std::string& sentence : words) sentence = "warning: " + sentence;
  return words;
}

std::vector<std::string> held_out_words(const std::vector<Judged>& judged, std::size_t of_no_walk) {
  int all = 0, unseen = 0, fitted = 0;
  std::set<int> epochs;
  for (const Judged& j : judged) {
    if (j.set != ReadingSet::validate) continue;
    ++all;
    unseen += j.standing == Standing::unseen ? 1 : 0;
    fitted += j.standing == Standing::fitted ? 1 : 0;
    if (j.standing == Standing::unknown_epoch) epochs.insert(j.epoch);
  }
  std::vector<std::string> words;
  if (of_no_walk > 0) {
    words.push_back(
        fmt::format("readings of walks that were stopped and walked anew judge nothing: {} of them",
                    of_no_walk));
  }
  if (fitted > 0) {
    words.push_back(fmt::format(
        "warning: {} of {} validation points stand where the correction was fitted: they are not "
        "held out, and count as in-sample",
        fitted, all));
  }
  if (!epochs.empty()) {
    words.push_back(fmt::format("warning: {} of {} validation points {}", all - unseen - fitted,
                                all, new_epoch_words({epochs.begin(), epochs.end()})));
  }
  if (unseen == 0) {
    words.push_back(
        "nothing of these readings is held out: in-sample figures do not say how good the "
        "correction "
        "is elsewhere; "
        "`trammel assess --job` cross-validates over spatial blocks");
  }
  return words;
}

std::string gains_in_words(const std::vector<Judged>& judged) {
  std::string text;
  for (const Counted& some : counted(judged)) {
    if (some.standing == Standing::unknown_epoch) continue;
    const Errors e = errors_in(Figure::position_mm, some.points);
    text += fmt::format("{}{} {} -> {} mm", text.empty() ? "" : ", ", name_of(some.standing),
                        terminal::figure_text(e.summary_before.mean),
                        terminal::figure_text(e.summary_after.mean));
  }
  return text;
}

std::string new_epoch_words(const std::vector<int>& epochs) {
  std::string numbers;
  for (const int epoch : epochs) numbers += (numbers.empty() ? "" : ", ") + std::to_string(epoch);
  return fmt::format(
      "were measured in epoch {}, of which no reading was fitted: how far homing and frame moved "
      "there is not known, so they do not judge the correction. Identify from readings of that "
      "epoch as well, or resume with reference points",
      numbers);
}

}  // namespace trammel::job
