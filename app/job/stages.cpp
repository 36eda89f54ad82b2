#include "app/job/stages.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/files/numbers.hpp"
#include "core/calibrate/joint_error.hpp"
#include "core/measure/bad_readings.hpp"
#include "core/measure/epochs.hpp"
#include "core/units.hpp"

namespace trammel::job {

namespace {

constexpr const char* kWithoutSuspects = "without_suspects";

}

void serves_measured(const Machine& machine) { require_all_measured(machine); }

std::span<const Stage> stages() {
  static const std::vector<Stage> all = {lsq_stage(),     geometry_stage(), idw_stage(),
                                         rbf_stage(),     gp_stage(),       hybrid_stage(),
                                         contest_stage(), diagnose_stage()};
  return all;
}

void require_within(const Fields& fields, const Json& all, const char* name, double low,
                    double high, const char* what) {
  const double value = all[name].get<double>();
  if (value >= low && value <= high) return;
  fields.refuse(name, std::string(what) + " out of range", fmt::format("{:g} to {:g}", low, high));
}

Json completed(const Stage& stage, Json given) {
  bool without = false;
  if (const auto at = given.find(kWithoutSuspects); at != given.end()) {
    const JsonFile file = parse_json(given.dump(), "parameters of " + stage.name);
    without = Fields(file).boolean(kWithoutSuspects, false);
    given.erase(kWithoutSuspects);
  }
  Json all = stage.complete(given);
  if (without) all[kWithoutSuspects] = true;
  return all;
}

Campaign as_asked(Campaign campaign, const Json& parameters) {
  if (!parameters.value(kWithoutSuspects, false)) return campaign;
  const std::vector<Suspicion> bad = bad_readings(campaign);
  std::erase_if(campaign.readings, [&](const Reading& r) {
    return std::ranges::any_of(bad, [&](const Suspicion& s) { return s.seqs.front() == r.seq; });
  });
  return campaign;
}

const Stage& find_stage(const std::string& name) {
  std::string known;
  for (const Stage& stage : stages()) {
    if (stage.name == name) return stage;
    known += (known.empty() ? "" : ", ") + stage.name;
  }
  throw NotFoundError({.what = "there is no such calibration", .got = name, .expected = known});
}

std::vector<Reading> identify_rows(const Campaign& campaign) {
  std::vector<Reading> rows;
  rows.reserve(campaign.readings.size());
  for (const Reading& r : campaign.readings) {
    if (r.set == ReadingSet::identify && r.measured) rows.push_back(r);
  }
  if (rows.empty()) {
    throw InputError({.what = "there is nothing to calibrate from",
                      .got = std::to_string(campaign.readings.size()) +
                             " readings, none of them in the set 'identify'",
                      .expected = "measured readings of the set 'identify'",
                      .hint = "name other sessions with --session, or measure a baseline"});
  }
  return rows;
}

std::vector<Reading> with_epochs(std::vector<Reading> rows, const Machine& machine,
                                 const std::string& choice, std::vector<std::string>& words) {
  bool shared = choice == "shared";
  if (choice == "auto") {
    const EpochTest test = test_epochs(machine, rows);
    shared = test.hold;
    if (test.later_epochs > 0) {
      words.push_back(
          test.hold ? fmt::format("epochs: no step between the {} epochs beyond chance ({:g} %): "
                                  "fitted as one (--own-epochs for shifts of their own)",
                                  test.later_epochs + 1, 100 * test.level)
                    : fmt::format("epochs: {}: each later one has joint zeros and a frame of its "
                                  "own, which its commands use",
                                  test.tested ? "a step between them is beyond chance"
                                              : "too few readings to see whether they hold"));
    }
  }
  if (!shared || rows.empty()) return rows;
  const int first = std::ranges::min(rows, {}, [](const Reading& r) {
                      return r.conditions.epoch;
                    }).conditions.epoch;
  for (Reading& r : rows) r.conditions.epoch = first;
  return rows;
}

MapRows map_rows(const Campaign& campaign, const Json& parameters, StageResult& out) {
  const std::vector<Reading> rows = with_epochs(identify_rows(campaign), campaign.machine,
                                                parameters["epochs"].get<std::string>(), out.words);
  MapRows found{.rows = {}, .shifts = epoch_shifts(campaign.machine, rows)};
  found.rows = without_shifts(rows, found.shifts);
  for (const auto& [epoch, shift] : found.shifts) {
    const Pose& f = shift.frame;
    const Displacements& l = shift.l_zero_mm;
    out.words.push_back(fmt::format(
        "epoch {}: frame {:+.4f}, {:+.4f} mm and {:+.4f} deg, joint zeros {:+.4f}, "
        "{:+.4f}, {:+.4f} "
        "mm from the first epoch, taken out before the map was made",
        epoch, rounded(f.x_mm, 4), rounded(f.y_mm, 4), rounded(deg_from_rad(f.phi_rad), 4),
        rounded(l[0], 4), rounded(l[1], 4), rounded(l[2], 4)));
  }
  return found;
}

}  // namespace trammel::job
