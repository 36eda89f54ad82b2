#include "app/files/layout.hpp"

#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using nlohmann::json;

namespace {

const std::string kTrackerFiles = tests::source_folder() + "/examples/tracker-files/";

json layout_json(const std::string& name) {
  return json::parse(tests::read_text(kTrackerFiles + name));
}

Layout layout_of(const json& layout) {
  const tests::TemporaryFolder folder;
  return read_layout(folder.write("layout.json", layout.dump(1)));
}

/// The example with a change; `pointer` and `value` as in a JSON patch; null removes.
json changed(const std::string& pointer, const json& value) {
  json layout = layout_json("spatialanalyzer.layout.json");
  const json::json_pointer at(pointer);
  if (value.is_null()) {
    layout.at(at.parent_pointer()).erase(at.back());
  } else {
    layout[at] = value;
  }
  return layout;
}

}  // namespace

TEST_CASE("the layouts that are there to be copied are valid and say what they say", "[points]") {
  for (const char* name : {"spatialanalyzer.layout.json", "leica.layout.json"}) {
    CAPTURE(name);
    CHECK(tests::schema_errors(layout_json(name), "layout.schema.json") == "");
  }
  const Layout sa = read_layout(kTrackerFiles + "spatialanalyzer.layout.json");
  CHECK(sa.simulated);
  CHECK(sa.points.format == "sa");
  CHECK(sa.points.date == DateOrder::month_first);
  CHECK(sa.body.body.size() == 3);
  CHECK(sa.frame.from == FrameFrom::base_nests);
  CHECK(sa.frame.base[2].at_mm == Eigen::Vector3d(0, 500, 20));
  CHECK(sa.rows.by_name);
  const Layout leica = read_layout(kTrackerFiles + "leica.layout.json");
  CHECK(leica.frame.from == FrameFrom::zeroing);
  CHECK(leica.frame.up == Eigen::Vector3d(0, 0, 1));
  CHECK(leica.rows.nests == std::vector<std::string>{"P1", "P2", "P3"});
  CHECK(leica.rows.repeats == 2);
  CHECK(leica.points.misses.size() == 3);
}

TEST_CASE("what a layout must say and does not is refused with its place, by the schema too",
          "[points]") {
  struct Case {
    const char* pointer;
    json value;
    const char* words;
  };
  for (const Case& c :
       std::vector<Case>{{"/kind", nullptr, "kind"},
                         {"/points/unit", nullptr, "unit"},
                         {"/points/unit", "furlong", "mm, m, um, in"},
                         {"/points/misses", {"nothing"}, "zero, empty, deleted"},
                         {"/sigma_mm", 0, "sigma_mm"},
                         {"/sigma_mm", 50, "sigma_mm"},
                         {"/nests", json::array({{{"nest", "P1"}, {"x_mm", 0}, {"y_mm", 0}}}),
                          "one nest shows no phi"},
                         {"/frame/nests", json::array(), "3 or more"},
                         {"/frame/from", "sky", "robot, base-nests, zeroing"},
                         {"/frame/up", "+z", "unknown field 'up'"},
                         {"/frame/false_alarm", 1.5, "false_alarm"},
                         {"/rows/by", "chance", "name, order"},
                         {"/rows/repeats", 2, "unknown field 'repeats'"},
                         {"/surprise", 1, "unknown field 'surprise'"}}) {
    CAPTURE(c.pointer);
    CHECK_THROWS_WITH(layout_of(changed(c.pointer, c.value)),
                      Contains("layout.json:") && Contains(c.words));
    CHECK(tests::schema_errors(changed(c.pointer, c.value), "layout.schema.json") != "");
  }
}

TEST_CASE("names that don't say the pose, nests twice and nests in two places are refused",
          "[points]") {
  CHECK_THROWS_WITH(layout_of(changed("/rows/point", "P")), Contains("{nest}"));
  CHECK_THROWS_WITH(layout_of(changed("/nests/1/nest", "P1")), Contains("duplicate nest"));
  CHECK_THROWS_WITH(layout_of(changed("/nests/1/nest", "B1")),
                    Contains("platform and on the base"));
  CHECK_THROWS_WITH(layout_of(changed("/nests/1/x_mm", 1e9)), Contains("is the unit right?"));
  json order = layout_json("leica.layout.json");
  order["rows"]["nests"] = {"P1", "P9"};
  CHECK_THROWS_WITH(layout_of(order), Contains("P9"));
  order["rows"]["nests"] = {"P1", "P2", "P1"};
  CHECK_THROWS_WITH(layout_of(order), Contains("repeats"));
}
