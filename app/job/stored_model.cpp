#include "app/job/stored_model.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/files/numbers.hpp"
#include "app/job/run.hpp"
#include "app/terminal/text.hpp"
#include "core/units.hpp"

namespace trammel::job {

namespace {

/// What the fit said of one parameter, as the chain of models stores it.
struct Fitted {
  double value = 0;
  std::optional<double> std;
  bool identified = true;
};

/// By "group name".
using FittedByName = std::map<std::string, Fitted>;

FittedByName fitted_of(const Json& parameters) {
  FittedByName all;
  for (const Json& e : parameters.value("effects", Json::array())) {
    all[e["effect"].get<std::string>() + " " + e["name"].get<std::string>()] = {
        .value = e["value"], .std = optional_number(e, "std")};
  }
  for (const Json& g : parameters.value("geometry", Json::array())) {
    all["geometry " + g["name"].get<std::string>()] = {
        .value = optional_number(g, "change").value_or(0),
        .std = optional_number(g, "std"),
        .identified = g["identified"]};
  }
  return all;
}

/// A standard deviation belongs to the value it was fitted with.
bool same_fit(double a, double b) { return std::abs(a - b) <= 1e-6 * std::abs(b); }

void attach(ModelParameter& p, const std::string& key, const FittedByName& fitted) {
  const auto at = fitted.find(key);
  if (at == fitted.end()) return;
  p.not_identified = !at->second.identified;
  if (at->second.identified && same_fit(at->second.value, p.change)) p.std = at->second.std;
}

void add_geometry(StoredModel& model, const FittedByName& fitted) {
  for (const MachineParameter& g : parameters_of(*model.robot.nominal.kind)) {
    const auto chain = static_cast<std::size_t>(g.chain);
    const double value = model.robot.machine.chains[chain][g.place];
    const double nominal = model.robot.nominal.chains[chain][g.place];
    const auto out = [&](double v) { return g.is_angle ? deg_from_rad(v) : v; };
    ModelParameter p{.group = "geometry",
                     .name = g.name,
                     .unit = g.is_angle ? "deg" : "mm",
                     .value = out(value),
                     .change = out(value - nominal),
                     .std = {}};
    attach(p, "geometry " + g.name, fitted);
    model.parameters.push_back(p);
  }
}

void add_epochs(StoredModel& model, const FittedByName& fitted) {
  for (const auto& [epoch, shift] : model.robot.epochs) {
    const std::string group = "epoch " + std::to_string(epoch);
    const auto add = [&](const std::string& name, const char* unit, double value) {
      ModelParameter p{
          .group = group, .name = name, .unit = unit, .value = value, .change = value, .std = {}};
      attach(p, "geometry " + name + " of " + group, fitted);
      model.parameters.push_back(p);
    };
    for (int i = 0; i < kChains; ++i) {
      add("l_zero_" + std::to_string(i + 1), "mm", shift.l_zero_mm[i]);
    }
    add("frame x", "mm", shift.frame.x_mm);
    add("frame y", "mm", shift.frame.y_mm);
    add("frame phi", "deg", deg_from_rad(shift.frame.phi_rad));
  }
}

void add_effects(StoredModel& model, const FittedByName& fitted) {
  for (const ActiveEffect& active : model.robot.effects) {
    for (Eigen::Index k = 0; k < active.values.size(); ++k) {
      const EffectParameter& e = active.effect->parameters[static_cast<std::size_t>(k)];
      const double value = active.values[k];
      if (value == 0) continue;
      ModelParameter p{.group = active.effect->name,
                       .name = e.name,
                       .unit = e.unit,
                       .value = value,
                       .change = value,
                       .std = {}};
      attach(p, active.effect->name + " " + e.name, fitted);
      model.parameters.push_back(p);
    }
  }
}

RobotModel robot_of(const store::Model& row) {
  const JsonFile file =
      parse_json(row.data.parameters_json, fmt::format("stored model version {}", row.version));
  Fields top(file);
  const Correction correction = read_correction(top.object("correction"));
  const auto* model = std::get_if<ModelCorrection>(&correction);
  if (model == nullptr) top.refuse("correction", "this version holds no physical model");
  return model->model;
}

[[noreturn]] void no_version(const std::vector<store::Model>& all, const std::string& campaign,
                             const std::string& text) {
  throw NotFoundError(
      {.what = "the campaign has no such version of its model",
       .where = {.field = "version"},
       .got = text,
       .expected = all.empty() ? "none is stored yet" : fmt::format("1 to {}, or last", all.size()),
       .hint = all.empty()
                   ? "`trammel diagnose " + terminal::shell_word(campaign) + "` makes the first"
                   : "see `trammel model list " + terminal::shell_word(campaign) + "`"});
}

std::string joined(const std::vector<std::string>& words) {
  return fmt::format("{}", fmt::join(words, ", "));
}

}  // namespace

StoredModel find_model(store::Connection& connection, const store::CampaignRow& campaign,
                       const std::string& text) {
  const std::vector<store::Model> all = store::list_models(connection, campaign.id);
  const auto number = text == "last" && !all.empty() ? all.back().version : parse_integer(text);
  const auto at = std::find_if(all.begin(), all.end(),
                               [&](const store::Model& m) { return number == m.version; });
  if (at == all.end()) no_version(all, campaign.name, text);
  StoredModel model{.row = *at, .robot = robot_of(*at), .parameters = {}};
  const FittedByName fitted = fitted_of(Json::parse(at->data.parameters_json));
  add_geometry(model, fitted);
  add_epochs(model, fitted);
  add_effects(model, fitted);
  return model;
}

std::vector<std::string> not_identified(const StoredModel& model) {
  std::vector<std::string> names;
  for (const ModelParameter& p : model.parameters) {
    if (!p.not_identified) continue;
    names.push_back(p.group == "geometry" ? p.name : p.name + " of " + p.group);
  }
  return names;
}

std::vector<std::string> model_words(const StoredModel& model) {
  std::vector<std::string> words;
  const std::vector<std::string> loose = not_identified(model);
  if (!loose.empty()) {
    words.push_back(fmt::format(
        "{} of {} parameters of geometry and epochs are not identified by themselves, only "
        "combinations of them are: {}. Their values are the least change that explains the "
        "readings; predicted poses do not depend on the choice where the readings were taken.",
        loose.size(),
        std::count_if(model.parameters.begin(), model.parameters.end(),
                      [](const ModelParameter& p) {
                        return p.group == "geometry" || p.group.starts_with("epoch ");
                      }),
        joined(loose)));
  }
  const bool nominal = std::all_of(model.parameters.begin(), model.parameters.end(),
                                   [](const ModelParameter& p) { return p.change == 0; });
  const bool any_std = std::any_of(model.parameters.begin(), model.parameters.end(),
                                   [](const ModelParameter& p) { return p.std.has_value(); });
  if (nominal) {
    words.emplace_back("Nothing is fitted: this is the robot as its maker states it.");
  } else if (!any_std && loose.empty()) {
    words.emplace_back("No standard deviations are stored with this version.");
  }
  return words;
}

std::vector<ParameterDifference> differences(const StoredModel& a, const StoredModel& b) {
  std::vector<ParameterDifference> all;
  const auto find = [](const StoredModel& in, const ModelParameter& p) {
    const auto at = std::find_if(in.parameters.begin(), in.parameters.end(), [&](const auto& q) {
      return q.group == p.group && q.name == p.name;
    });
    return at == in.parameters.end() ? std::nullopt : std::optional(*at);
  };
  for (const ModelParameter& p : a.parameters) {
    const auto other = find(b, p);
    if (!other || other->value != p.value) all.push_back({p, other});
  }
  for (const ModelParameter& p : b.parameters) {
    if (!find(a, p)) all.push_back({std::nullopt, p});
  }
  return all;
}

std::vector<std::string> idle_effects(const RobotModel& robot, bool has_temperature,
                                      bool has_time) {
  std::vector<std::string> idle;
  for (const ActiveEffect& active : robot.effects) {
    if (active.effect->recall != nullptr && robot.history == nullptr) {
      idle.push_back("what " + active.effect->name +
                     " remembers of a campaign: temperatures are taken to be steady, and moves to "
                     "be long unless they are given");
    }
    for (const Need need : active.effect->needs) {
      if (need == Need::temperature && !has_temperature) {
        idle.push_back(active.effect->name + " needs a temperature");
      }
      if (need == Need::time && !has_time) idle.push_back(active.effect->name + " needs a time");
    }
  }
  return idle;
}

store::Id find_compensation(store::Connection& connection, const std::string& campaign,
                            const std::string& text) {
  constexpr std::string_view kModel = "model:";
  if (!text.starts_with(kModel)) return find(connection, text).id;
  const StoredModel model = find_model(connection, store::require_campaign(connection, campaign),
                                       text.substr(kModel.size()));
  if (model.row.data.job_id) {
    const Correction of_job = correction_of(connection, *model.row.data.job_id);
    if (correction_json(of_job) == correction_json(ModelCorrection{model.robot})) {
      return *model.row.data.job_id;
    }
  }
  throw InputError(
      {.what = "a session commands the correction of a job, and this version is only a step of one",
       .where = {.field = "--compensate"},
       .got = text,
       .expected = "the last version of a diagnosis",
       .hint = "`trammel calibrate geometry " + terminal::shell_word(campaign) +
               " --effects NAME,…` makes a job of it"});
}

}  // namespace trammel::job
