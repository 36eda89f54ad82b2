#include "app/files/plan_json.hpp"

#include <algorithm>
#include <array>

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

}  // namespace

Approach read_approach(Fields& fields) {
  Approach approach = {0, 0, 0};
  if (!fields.has("approach")) return approach;
  const std::vector<double> values = fields.numbers("approach");
  if (values.size() != kChains) fields.refuse("approach", "wrong number of rails", "three of them");
  for (std::size_t i = 0; i < kChains; ++i) {
    if (values[i] != -1 && values[i] != 0 && values[i] != 1) {
      fields.refuse("approach", "no direction", "-1, 0 or 1");
    }
    approach[i] = static_cast<int>(values[i]);
  }
  return approach;
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
