#include "app/job/diagnosis_json.hpp"
#include "app/job/model_chain.hpp"
#include "app/job/stages.hpp"

namespace trammel::job {

namespace {

constexpr int kMostReplicates = 100000;

Json complete_diagnosis(const Json& given) {
  const JsonFile file = parse_json(given.dump(), "parameters of diagnose");
  Fields f(file);
  const DiagnoseOptions defaults;
  Json all = {{"seed", f.integer("seed", 1)},
              {"replicates", f.integer("replicates", defaults.replicates)},
              {"false_alarm", f.number("false_alarm", defaults.false_alarm)},
              {"epochs", f.choice("epochs", {"own", "shared"}, "own")},
              {"inadequate", f.number("inadequate", defaults.inadequate)}};
  f.done();
  const auto replicates = all["replicates"].get<long long>();
  if (replicates < 100 || replicates > kMostReplicates) {
    f.refuse("replicates", "the bootstrap needs a sensible number", "100 to 100000");
  }
  for (const char* level : {"false_alarm", "inadequate"}) {
    const double value = all[level].get<double>();
    if (!(value > 0 && value < 0.5))
      f.refuse(level, "a false-alarm rate", "more than 0, less than 0.5");
  }
  return all;
}

/// All readings as of one homing and frame set-up: for a stage that homes exactly.
Campaign in_one_epoch(Campaign campaign) {
  for (Reading& reading : campaign.readings) reading.conditions.epoch = 1;
  return campaign;
}

StageResult run_diagnosis(const Campaign& measured, const Json& p) {
  const Campaign campaign = p["epochs"] == "shared" ? in_one_epoch(measured) : measured;
  const Diagnosis d = diagnose(campaign, {.false_alarm = p["false_alarm"].get<double>(),
                                          .inadequate = p["inadequate"].get<double>(),
                                          .seed = p["seed"].get<std::uint64_t>(),
                                          .replicates = p["replicates"].get<int>()});
  StageResult out;
  out.correction = ModelCorrection{d.fit.model};
  out.details = diagnosis_json(d, campaign.name);
  out.details["models"] = model_chain_json(d);
  return out;
}

}  // namespace

Stage diagnose_stage() {
  return {.name = "diagnose",
          .algorithm_version = 1,
          .what = "the discrepancy workflow: which physical effect the model is missing",
          .complete = complete_diagnosis,
          .run = run_diagnosis};
}

}  // namespace trammel::job
