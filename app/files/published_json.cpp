#include "app/files/published_json.hpp"

#include "app/files/json_file.hpp"

namespace trammel {

namespace {

using Json = nlohmann::ordered_json;

std::vector<double> three(Fields& fields, const std::string& name) {
  std::vector<double> values = fields.numbers(name);
  if (values.size() != 3) fields.refuse(name, "three numbers are needed", "three numbers");
  return values;
}

Published published(Fields& fields) {
  Published found;
  for (Fields& t : fields.objects("tables")) {
    found.tables.push_back({.id = t.text("id"),
                            .table = t.text("table"),
                            .in_sample = t.boolean("in_sample", false),
                            .before = three(t, "before"),
                            .after = three(t, "after")});
    t.done();
  }
  for (Fields& p : fields.objects("parameters")) {
    const std::string name = p.text("name");
    found.parameters[name] = p.number("value");
    p.done();
  }
  if (fields.has("circles_after_mm")) found.circles_after_mm = three(fields, "circles_after_mm");
  found.network_mae_mm = fields.optional_number("network_mae_mm");
  found.network_mse_mm2 = fields.optional_number("network_mse_mm2");
  if (fields.has("network_r2_pearson")) {
    found.network_r2_pearson = three(fields, "network_r2_pearson");
  }
  fields.done();
  return found;
}

Json json_of(const Published& p) {
  Json tables = Json::array(), parameters = Json::array();
  for (const PublishedTable& t : p.tables) {
    tables.push_back({{"id", t.id},
                      {"table", t.table},
                      {"in_sample", t.in_sample},
                      {"before", t.before},
                      {"after", t.after}});
  }
  for (const auto& [name, value] : p.parameters) {
    parameters.push_back({{"name", name}, {"value", value}});
  }
  Json json = {{"tables", tables}, {"parameters", parameters}};
  if (!p.circles_after_mm.empty()) json["circles_after_mm"] = p.circles_after_mm;
  if (p.network_mae_mm) json["network_mae_mm"] = *p.network_mae_mm;
  if (p.network_mse_mm2) json["network_mse_mm2"] = *p.network_mse_mm2;
  if (!p.network_r2_pearson.empty()) json["network_r2_pearson"] = p.network_r2_pearson;
  return json;
}

}  // namespace

std::string read_published(Fields fields) { return json_of(published(fields)).dump(); }

std::optional<Published> published_of(const Campaign& campaign) {
  const auto fact = campaign.facts.find(kPublishedFact);
  if (fact == campaign.facts.end()) return std::nullopt;
  const JsonFile file = parse_json(fact->second, "the campaign's fact published");
  Fields fields(file);
  return published(fields);
}

}  // namespace trammel
