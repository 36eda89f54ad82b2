#pragma once
// Model versions of a campaign as numbers with names, units and standard deviations.

#include <optional>
#include <string>
#include <vector>

#include "app/job/correction_json.hpp"
#include "store/campaign.hpp"
#include "store/model.hpp"

namespace trammel::job {

/// One value of a model, in the unit of reports.
struct ModelParameter {
  std::string group;  // "geometry", "epoch 2", or the effect's name
  std::string name;   // "alpha_1", "l_zero_2", "k_3"
  std::string unit;
  double value = 0;
  double change = 0;            // from nominal; of epochs and effects the value itself
  std::optional<double> std;    // none: not determined by itself, or not stored with this version
  bool not_identified = false;  // only combinations with other parameters are
  bool operator==(const ModelParameter&) const = default;
};

struct StoredModel {
  store::Model row;
  RobotModel robot;
  std::vector<ModelParameter> parameters;  // 21 of geometry, then epochs, then effects that act
};

/// Version `text` of the campaign's models: its number, or "last".
/// @throws NotFoundError  that names the versions there are
/// @throws InputError     the stored version holds no physical model
StoredModel find_model(store::Connection& connection, const store::CampaignRow& campaign,
                       const std::string& text);

/// Names of the geometry and epoch parameters the readings do not determine by themselves.
std::vector<std::string> not_identified(const StoredModel& model);

/// What a version's standard deviations and unidentified parameters mean, one sentence each.
std::vector<std::string> model_words(const StoredModel& model);

/// Of two versions, the parameters that differ: a value that one of them lacks is none.
struct ParameterDifference {
  std::optional<ModelParameter> a, b;
};
std::vector<ParameterDifference> differences(const StoredModel& a, const StoredModel& b);

/// Effects of the model that do nothing under these conditions, because what they need is not
/// recorded: {"thermal_growth needs a temperature"}.
std::vector<std::string> idle_effects(const RobotModel& robot, bool has_temperature, bool has_time);

/// The job whose correction `text` names: a job's number or key, or model:VERSION when a job of the
/// campaign computed just this version.
/// @throws InputError  no job's correction is this version (a step on the way of a diagnosis)
store::Id find_compensation(store::Connection& connection, const std::string& campaign,
                            const std::string& text);

}  // namespace trammel::job
