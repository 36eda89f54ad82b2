#pragma once
// The calibrations as stages: named, versioned functions from readings and parameters to a result.

#include <span>
#include <string>
#include <vector>

#include "app/job/correction_json.hpp"
#include "core/measure/reading.hpp"

namespace trammel::job {

/// What a stage found: the correction, all figures for storing, and sentences for a person.
struct StageResult {
  Correction correction;
  Json details = Json::object();
  std::vector<std::string> words;
  Json timing = Json::object();  // what a re-run may not repeat
};

struct Stage {
  std::string name;
  int algorithm_version = 1;  // bump when a result changes: a test holds each version's result
  std::string what;           // one line for the help
  /// The parameters in full: defaults filled in, unknown or wrong ones refused (InputError).
  Json (*complete)(const Json& given);
  /// Fits the identify rows of `campaign`. `parameters` are complete.
  StageResult (*run)(const Campaign& campaign, const Json& parameters);
  /// Refuses a machine that the stage does not serve, with what does (InputError); null: all.
  void (*serves)(const Machine& machine) = nullptr;
};

/// Refuses the number `name` of `all` outside its bounds, with what it is (InputError).
void require_within(const Fields& fields, const Json& all, const char* name, double low,
                    double high, const char* what);

/// The parameters in full, those of the stage and what all stages share: "without_suspects", true
/// or absent.
Json completed(const Stage& stage, Json given);
/// `campaign` without its bad readings (core/measure/bad_readings.hpp) where the parameters ask.
Campaign as_asked(Campaign campaign, const Json& parameters);

/// All stages: lsq, geometry, idw, rbf, gp, hybrid, contest, diagnose.
std::span<const Stage> stages();

/// Throws NotFoundError that lists the stages there are.
const Stage& find_stage(const std::string& name);

/// The identify rows that have a measured pose. Throws InputError when there are none.
std::vector<Reading> identify_rows(const Campaign& campaign);

/// `rows` with the epochs that a fit gives parameters of their own: as recorded ("own"), one
/// ("shared"), or one where the readings show no step between epochs ("auto", test_epochs); `words`
/// get what was found where there is more than one.
std::vector<Reading> with_epochs(std::vector<Reading> rows, const Machine& machine,
                                 const std::string& choice, std::vector<std::string>& words);

/// What a map is made of: the identify rows as they would have been in the first epoch, and the
/// shifts of the later ones that were taken out of them, by the rule of with_epochs.
struct MapRows {
  std::vector<Reading> rows;
  EpochShifts shifts;
};
MapRows map_rows(const Campaign& campaign, const Json& parameters, StageResult& out);

/// Of maps: every coordinate that the machine moves is measured.
void serves_measured(const Machine& machine);

Stage lsq_stage();
Stage idw_stage();
Stage rbf_stage();
Stage gp_stage();
Stage geometry_stage();
Stage hybrid_stage();
Stage contest_stage();
Stage diagnose_stage();

}  // namespace trammel::job
