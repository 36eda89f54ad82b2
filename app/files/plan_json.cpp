#include "app/files/plan_json.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include "app/files/fields.hpp"
#include "app/files/format.hpp"
#include "app/files/numbers.hpp"
#include "core/error.hpp"
#include "core/plan/named.hpp"
#include "core/units.hpp"
#include "store/reading.hpp"

namespace trammel {

namespace {

using Json = nlohmann::ordered_json;

Json point_json(const PlannedPoint& p) {
  Json json = {{"seq", p.seq},
               {"x_mm", p.target.x_mm},
               {"y_mm", p.target.y_mm},
               {"phi_deg", exact_deg(p.target.phi_rad)}};
  if (p.set != ReadingSet::identify) json["set"] = store::name_of(p.set);
  if (p.approach != Approach{0, 0, 0}) json["approach"] = p.approach;
  if (p.repeat != 1) json["repeat"] = p.repeat;
  if (p.reference) json["reference"] = true;
  if (!p.group.empty()) json["group"] = p.group;
  return json;
}

PlannedPoint read_point(Fields& fields) {
  PlannedPoint p;
  p.seq = fields.integer("seq");
  p.target = {fields.number("x_mm"), fields.number("y_mm"),
              rad_from_deg(fields.number("phi_deg", 0))};
  p.set = store::reading_set(fields.choice("set", {"identify", "validate"}, "identify"));
  p.approach = read_approach(fields);
  p.repeat = fields.integer("repeat", 1);
  p.reference = fields.boolean("reference", false);
  p.group = fields.text("group", "");
  fields.done();
  return p;
}

/// [1, 0, -1], [1, -1] on a machine of two drives; else nothing.
std::optional<Approach> approach_of(const nlohmann::json& directions) {
  if (!directions.is_array() || directions.empty() || directions.size() > kChains) return {};
  Approach approach = {0, 0, 0};
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const nlohmann::json& d = directions[i];
    if (d != -1 && d != 0 && d != 1) return std::nullopt;
    approach[i] = d.get<int>();
  }
  return approach;
}

constexpr const char* kDirections = "-1, 0 or 1 for each drive";

}  // namespace

Approach read_approach(Fields& fields) {
  if (!fields.has("approach")) return {0, 0, 0};
  const auto approach = approach_of(fields.value().at("approach"));
  if (!approach) fields.refuse("approach", "no direction", kDirections);
  return *approach;
}

std::vector<Approach> read_approaches(Fields& fields) {
  const nlohmann::json* lists =
      fields.has("approaches") ? &fields.value().at("approaches") : nullptr;
  std::vector<Approach> all;
  if (lists != nullptr && lists->is_array()) {
    for (const nlohmann::json& directions : *lists) {
      const auto approach = approach_of(directions);
      if (!approach) break;
      all.push_back(*approach);
    }
  }
  if (lists == nullptr || all.empty() || all.size() != lists->size()) {
    fields.refuse("approaches", "no directions",
                  std::string("one or more lists of ") + kDirections);
  }
  return all;
}

Json plan_json(const Plan& plan) {
  Json points = Json::array();
  for (const PlannedPoint& point : plan.points) points.push_back(point_json(point));
  return {{"schema", "trammel/plan/1"},
          {"name", plan.name},
          {"approach_mm", plan.approach_mm},
          {"points", points}};
}

Plan read_plan(const std::filesystem::path& path) {
  const JsonFile file = read_json(path);
  Fields top(file);
  take_format(top, "trammel/plan/1", "schema");
  Plan plan;
  plan.name = top.text("name");
  plan.approach_mm = top.number("approach_mm", plan.approach_mm);
  for (Fields& point : top.objects("points")) plan.points.push_back(read_point(point));
  top.done();
  try {
    validate(plan);
  } catch (const InputError& error) {
    ErrorText text = error.text();
    text.where.file = file.name;
    throw InputError(text);
  }
  return plan;
}

Plan plan_of(const std::string& name_or_file) {
  const auto& names = grid_names();
  if (std::find(names.begin(), names.end(), name_or_file) != names.end()) {
    return named_plan(name_or_file);
  }
  return read_plan(name_or_file);
}

Json violations_json(const std::vector<Violation>& violations) {
  Json all = Json::array();
  for (const Violation& v : violations) {
    Json json = {{"point", v.seq}, {"place", name_of(v.place)}, {"what", name_of(v.what)}};
    if (v.rail > 0) json["rail"] = v.rail;
    if (v.got != 0 || v.limit != 0) {
      json["got"] = v.got;
      json["limit"] = v.limit;
    }
    all.push_back(json);
  }
  return all;
}

}  // namespace trammel
