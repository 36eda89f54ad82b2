#include "app/session/settings.hpp"

#include <nlohmann/json.hpp>

#include "core/error.hpp"

namespace trammel::session {

using SortedJson = nlohmann::json;

std::string settings_json(const Settings& s) {
  const SortedJson json = {{"ordinal", s.ordinal},
                           {"start_s", s.start_s},
                           {"end_s", s.end_s},
                           {"approach_mm", s.approach_mm},
                           {"identity", s.identity},
                           {"limit_margin_mm", s.check.limit_margin_mm},
                           {"singularity_margin", s.check.singularity_margin},
                           {"path_step_mm", s.check.path_step_mm}};
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
            .check = {.limit_margin_mm = json.at("limit_margin_mm").get<double>(),
                      .singularity_margin = json.at("singularity_margin").get<double>(),
                      .path_step_mm = json.at("path_step_mm").get<double>()}};
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
