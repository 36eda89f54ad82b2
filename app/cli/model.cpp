#include "app/cli/model.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/job/model_json.hpp"
#include "app/job/stored_model.hpp"
#include "app/job/text.hpp"
#include "app/terminal/decimals.hpp"
#include "app/terminal/table.hpp"
#include "store/open.hpp"

namespace trammel::cli {

namespace {

using job::ModelParameter;
using job::StoredModel;

struct ModelOptions {
  std::string campaign;
  std::string version;
  std::string other;
};

/// Blank when there is none.
std::string cell(const std::optional<double>& value, const char* form) {
  return value ? fmt::format(fmt::runtime(form), *value) : "";
}

/// In mm; blank when there is none.
std::string figure(const std::optional<double>& value_mm) {
  return value_mm ? terminal::figure_text(*value_mm) : "";
}

std::string unit_words(const std::string& unit) { return unit == "1" ? "" : " " + unit; }

ExitCode run_list(const ModelOptions& options, Context& context) {
  store::Connection db = store::open(context.db(), store::Access::read_only);
  const store::CampaignRow campaign = store::require_campaign(db, options.campaign);
  Json rows = Json::array();
  Table table({"version", "name", "parent", "fitted rms mm", "unseen rms mm", "noise floor mm",
               "job", "key"});
  for (const store::Model& m : store::list_models(db, campaign.id)) {
    rows.push_back(job::model_row_json(m));
    table.add({std::to_string(m.version), m.data.name,
               m.data.parent ? std::to_string(*m.data.parent) : "", figure(m.data.identify_rms_mm),
               figure(m.data.validate_rms_mm), figure(m.data.noise_floor_mm),
               m.data.job_id ? std::to_string(*m.data.job_id) : "", m.job_key.substr(0, 12)});
  }
  const std::string name = shell_word(campaign.name);
  if (context.json) {
    context.print("model-list", {{"campaign", campaign.name}, {"models", rows}});
  } else if (rows.empty()) {
    context.print("no models yet");
  } else {
    context.print(table.text());
  }
  context.next(rows.empty() ? "trammel diagnose " + name : "trammel model show " + name + " last");
  return ExitCode::ok;
}

std::string effect_text(const StoredModel& model) {
  std::string text;
  for (const ActiveEffect& active : model.robot.effects) {
    text += fmt::format("\n{}: {}\n", bold(active.effect->name), active.effect->sentence);
    for (const ModelParameter& p : model.parameters) {
      if (p.group != active.effect->name) continue;
      text += fmt::format("  {:<6} {:>13.6g}{}{}\n", p.name, p.value,
                          p.std ? fmt::format(" +- {:.2g}", *p.std) : "", unit_words(p.unit));
    }
  }
  return text;
}

std::string base_text(const StoredModel& model) {
  Table table({"base", "value", "change", "std", "unit", ""});
  bool any = false;
  for (const ModelParameter& p : model.parameters) {
    const bool geometry = p.group == "geometry";
    if (!geometry && !p.group.starts_with("epoch ")) continue;
    any = any || p.change != 0;
    const bool known = !p.not_identified;
    table.add({geometry ? p.name : p.name + " of " + p.group,
               known ? fmt::format("{:.6f}", p.value) : "-",
               known ? fmt::format("{:+.6f}", p.change) : "-", cell(p.std, "{:.6f}"), p.unit,
               known ? "" : "not by itself"});
  }
  return any ? "\n" + table.text() : "";
}

std::string title(const store::CampaignRow& campaign) {
  return job::campaign_title(printable(campaign.name), campaign.simulated);
}

std::string show_text(const StoredModel& model, const store::CampaignRow& campaign) {
  const store::NewModel& m = model.row.data;
  std::string text = fmt::format("{}\n", bold(fmt::format("model {} of {}: {}", model.row.version,
                                                          title(campaign), printable(m.name))));
  if (m.parent) text += fmt::format("made from   version {}\n", *m.parent);
  if (m.job_id) text += fmt::format("by          job {}, key {}\n", *m.job_id, model.row.job_key);
  const auto rms = [&text](const char* label, const std::optional<double>& value) {
    if (value) text += fmt::format("{} {} mm rms of measured - simulated\n", label, figure(value));
  };
  rms("fitted     ", m.identify_rms_mm);
  rms("unseen     ", m.validate_rms_mm);
  if (m.noise_floor_mm)
    text += fmt::format("sigma per coordinate {} mm\n", figure(m.noise_floor_mm));
  text += effect_text(model) + base_text(model);
  for (const std::string& sentence : job::model_words(model)) text += "\n" + sentence + "\n";
  return text;
}

ExitCode run_show(const ModelOptions& options, Context& context) {
  store::Connection db = store::open(context.db(), store::Access::read_only);
  const store::CampaignRow campaign = store::require_campaign(db, options.campaign);
  const StoredModel model = job::find_model(db, campaign, options.version);
  if (context.json) {
    context.print("model-show", job::model_json(model, campaign.name));
  } else {
    context.print(show_text(model, campaign));
  }
  context.next(fmt::format("trammel model export {} {} --out compensation.csv",
                           shell_word(campaign.name), model.row.version));
  return ExitCode::ok;
}

bool withheld(const std::optional<ModelParameter>& p) { return p && p->not_identified; }

/// A number stands only beside a parameter that is identified by itself.
Json value_json(const std::optional<ModelParameter>& p) {
  return p && !p->not_identified ? Json(p->value) : Json(nullptr);
}

Json std_json(const std::optional<ModelParameter>& p) {
  return p && p->std ? Json(*p->std) : Json(nullptr);
}

/// Of the gap: what each version leaves on each set.
struct Figure {
  const char* name;
  std::optional<double> store::NewModel::*of;
};
constexpr Figure kFigures[] = {{"identify_rms_mm", &store::NewModel::identify_rms_mm},
                               {"validate_rms_mm", &store::NewModel::validate_rms_mm},
                               {"noise_floor_mm", &store::NewModel::noise_floor_mm}};

Json diff_json(const StoredModel& a, const StoredModel& b, const std::string& campaign) {
  const auto side = [](const StoredModel& m) {
    return Json{{"version", m.row.version}, {"name", m.row.data.name}};
  };
  Json json = {{"campaign", campaign},
               {"a", side(a)},
               {"b", side(b)},
               {"figures", Json::array()},
               {"parameters", Json::array()}};
  for (const Figure& f : kFigures) {
    const auto va = a.row.data.*f.of, vb = b.row.data.*f.of;
    if (va == vb) continue;
    json["figures"].push_back(
        {{"name", f.name}, {"a", va ? Json(*va) : Json()}, {"b", vb ? Json(*vb) : Json()}});
  }
  for (const job::ParameterDifference& d : job::differences(a, b)) {
    const ModelParameter& any = d.a ? *d.a : *d.b;
    json["parameters"].push_back(
        {{"group", any.group},
         {"name", any.name},
         {"unit", any.unit},
         {"a", value_json(d.a)},
         {"b", value_json(d.b)},
         {"difference", withheld(d.a) || withheld(d.b)
                            ? Json(nullptr)
                            : Json((d.b ? d.b->value : 0) - (d.a ? d.a->value : 0))},
         {"std_a", std_json(d.a)},
         {"std_b", std_json(d.b)}});
  }
  return json;
}

std::string diff_text(const Json& diff) {
  if (diff["figures"].empty() && diff["parameters"].empty()) return "the versions are the same";
  const auto number = [](const Json& value) {
    return value.is_null() ? std::string() : fmt::format("{:.6g}", value.get<double>());
  };
  const auto head = [&diff](const char* side) {
    return fmt::format("{} {}", diff[side]["version"].get<int>(),
                       diff[side]["name"].get<std::string>());
  };
  Table table({"", head("a"), head("b"), "difference", "unit"});
  for (const Json& f : diff["figures"]) {
    table.add({f["name"], number(f["a"]), number(f["b"]), "", "mm"});
  }
  for (const Json& p : diff["parameters"]) {
    const std::string group = p["group"];
    table.add({(group == "geometry" ? "" : group + " ") + p["name"].get<std::string>(),
               number(p["a"]), number(p["b"]),
               p["difference"].is_null() ? "not by itself"
                                         : fmt::format("{:+.6g}", p["difference"].get<double>()),
               p["unit"]});
  }
  return table.text();
}

ExitCode run_diff(const ModelOptions& options, Context& context) {
  store::Connection db = store::open(context.db(), store::Access::read_only);
  const store::CampaignRow campaign = store::require_campaign(db, options.campaign);
  const Json diff = diff_json(job::find_model(db, campaign, options.version),
                              job::find_model(db, campaign, options.other), campaign.name);
  context.json ? context.print("model-diff", diff) : context.print(diff_text(diff));
  return ExitCode::ok;
}

}  // namespace

void setup_model(Command app, Context& context) {
  Command model =
      noun(app, "model", "The campaign's models: nominal, geometry, and each named effect added");
  const auto verb = [&](const char* name, const char* what,
                        ExitCode (*run)(const ModelOptions&, Context&)) {
    Command command = model.command(name, what);
    auto options = std::make_shared<ModelOptions>();
    command.option("CAMPAIGN", options->campaign, "Name or uuid").required();
    on_run(command, context, options, run);
    return std::pair(command, options.get());
  };
  verb("list", "All versions, each with what it leaves of the gap", run_list);
  const char* const which = "Number of the version, or last";
  const auto show = verb(
      "show", "Parameters with units and standard deviations, and what is not known", run_show);
  show.first.option("VERSION", show.second->version, which).required();
  const auto diff = verb("diff", "What differs between two versions, and nothing else", run_diff);
  diff.first.option("A", diff.second->version, which).required().type("VERSION");
  diff.first.option("B", diff.second->other, which).required().type("VERSION");
  setup_model_use(model, context);
}

}  // namespace trammel::cli
