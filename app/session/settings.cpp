#include "app/session/settings.hpp"

#include <array>
#include <nlohmann/json.hpp>

#include "app/session/written.hpp"
#include "core/error.hpp"

namespace trammel::session {

using SortedJson = nlohmann::json;

namespace {

struct Margin {
  const char* key;
  double CheckOptions::*value;
};
constexpr std::array<Margin, 7> kMargins = {{
    {"limit_margin_mm", &CheckOptions::limit_margin_mm},
    {"singularity_margin", &CheckOptions::singularity_margin},
    {"path_step_mm", &CheckOptions::path_step_mm},
    {"link_clearance_mm", &CheckOptions::link_clearance_mm},
    {"speed_mm_s", &CheckOptions::speed_mm_s},
    {"max_speed_mm_s", &CheckOptions::max_speed_mm_s},
    {"max_platform_mm_s", &CheckOptions::max_platform_mm_s},
}};

}  // namespace

nlohmann::json check_json(const CheckOptions& check) {
  SortedJson json;
  for (const Margin& margin : kMargins) json[margin.key] = check.*margin.value;
  return json;
}

CheckOptions read_check(const SortedJson& json) {
  CheckOptions check;
  for (const Margin& m : kMargins) check.*m.value = json.value(m.key, check.*m.value);
  return check;
}

CheckOptions read_check(Fields fields, const CheckOptions& absent) {
  CheckOptions check;
  for (const Margin& m : kMargins) {
    check.*m.value = fields.number(m.key, absent.*m.value);
    if (check.*m.value < 0) fields.refuse(m.key, "a margin that checks nothing", "0 or more");
  }
  fields.done();
  return check;
}

std::string settings_json(const Settings& s) {
  SortedJson json = check_json(s.check);
  json["ordinal"] = s.ordinal;
  json["start_s"] = s.start_s;
  json["end_s"] = s.end_s;
  json["approach_mm"] = s.approach_mm;
  json["identity"] = s.identity;
  json["policy"] = policy_json(s.policy);
  if (!s.plan_sha256.empty()) json["plan_sha256"] = s.plan_sha256;
  return json.dump();
}

Settings read_settings(const std::string& text) {
  try {
    const SortedJson json = SortedJson::parse(text);
    return {.ordinal = json.at("ordinal").get<int>(),
            .start_s = json.at("start_s").get<double>(),
            .end_s = json.at("end_s").get<double>(),
            .approach_mm = json.at("approach_mm").get<double>(),
            .identity = json.at("identity").get<std::string>(),
            .check = read_check(json),
            .policy = read_policy(json.value("policy", SortedJson::object())),
            .plan_sha256 = json.value("plan_sha256", std::string())};
  } catch (const SortedJson::exception& error) {
    throw StoreError({.what = "the session's settings cannot be read",
                      .got = error.what(),
                      .hint = "run `trammel db verify`"});
  }
}

bool has_settings(const std::string& text) {
  const SortedJson json = SortedJson::parse(text, nullptr, false);
  return json.is_object() && json.contains("ordinal");
}

}  // namespace trammel::session
