#include "app/files/json_file.hpp"

#include "app/files/fields.hpp"
#include "app/files/mechanism_json.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/workspace.hpp"

using namespace trammel;

namespace {

/// The error that `action` throws; fails when it throws none.
template <class Action>
ErrorText refusal_of(Action action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.text();
  }
  FAIL("nothing was refused");
  return {};
}

ErrorText parse_error(const std::string& text) {
  return refusal_of([&] { (void)parse_json(text, "a.json"); });
}

}  // namespace

TEST_CASE("every value of a JSON file knows its line and column", "[exchange]") {
  const JsonFile file = parse_json("{\n \"a\": [1, {\"b\": -2.5}],\n\t\"c\" :\"x\"}", "a.json");
  CHECK(file.where("a").line == 2);
  CHECK(file.where("a").column == 7);
  CHECK(file.where("a[0]").column == 8);
  CHECK(file.where("a[1]").column == 11);
  CHECK(file.where("a[1].b").column == 17);
  CHECK(file.where("c").line == 3);
  CHECK(file.where("c").column == 7);
  CHECK(file.where("").column == 1);
}

TEST_CASE("a duplicate key is refused where it stands the second time", "[exchange]") {
  const ErrorText error = parse_error("{\"a\": 1,\n \"a\": 2}");
  CHECK_THAT(error.what, Contains("duplicate key 'a'"));
  CHECK(error.where.file == "a.json");
  CHECK(error.where.line == 2);
  CHECK(error.where.column == 2);
}

TEST_CASE("a comment from // to the end of its line is a blank, and // in a text is no comment",
          "[exchange]") {
  const JsonFile file = parse_json(
      "// a \"file\"\n{ // of\n \"a\": 1, // two { values\n \"b\\\"//\": \"http://x\" }// end",
      "a.json");
  CHECK(file.value == nlohmann::json{{"a", 1}, {"b\"//", "http://x"}});
  CHECK(file.where("a").line == 3);
  CHECK(file.where("a").column == 7);
  CHECK(parse_error("{\"a\": 1, // twice\n \"a\": 2}").where.line == 2);
}

TEST_CASE("what is no JSON is refused with line and column", "[exchange]") {
  for (const char* bad : {"", "{", "[1,]", "{\"a\":NaN}", "{\"a\":Infinity}", "{\"a\":-inf}",
                          "{\"a\":0x10}", "{\"a\":1e999}", "{'a':1}", "{\"a\":1} x", "/* no */ {}",
                          "# no\n{}", "/ no\n{}", "// no", "{\"a\":01}", "\"\xff\""}) {
    CAPTURE(bad);
    const ErrorText error = parse_error(bad);
    CHECK(error.where.line >= 1);
    CHECK(error.where.column >= 1);
  }
  CHECK(parse_error("{\n\n \"a\": NaN}").where.line == 3);
}

TEST_CASE("nesting is capped", "[exchange]") {
  const std::string deep(kMaxJsonDepth, '[');
  CHECK_NOTHROW(parse_json(deep + std::string(kMaxJsonDepth, ']'), "a.json"));
  CHECK_THAT(parse_error("[" + deep).what, Contains("too deeply"));
  CHECK_THAT(parse_error(std::string(100000, '[')).what, Contains("too deeply"));
}

TEST_CASE("values, texts and paths are capped", "[exchange]") {
  std::string many = "[0";
  for (std::size_t k = 0; k < kMaxJsonValues; ++k) many += ",0";
  CHECK_THAT(parse_error(many + "]").what, Contains("too many values"));
  CHECK_THAT(parse_error("[\"" + std::string(kMaxJsonTextBytes + 1, 'x') + "\"]").what,
             Contains("a text of 100001 bytes"));
  const std::string key = "{\"" + std::string(200, 'k') + "\": ";
  CHECK_NOTHROW(parse_json(key + key + "1}}", "a.json"));
  CHECK_THAT(parse_error(key + key + key + "1}}}").what, Contains("too long"));
}

TEST_CASE("a missing file is not found", "[exchange]") {
  CHECK_THROWS_AS(read_json("/nonexistent/a.json"), NotFoundError);
}

TEST_CASE("Fields name the path of a wrong type, a missing and an unknown field", "[exchange]") {
  const JsonFile file =
      parse_json("{\"a\": {\"b\": [{\"n\": \"x\"}]},\n \"i\": 1.5, \"u\": 0}", "f");
  Fields top(file);
  Fields b = top.object("a").objects("b").front();
  const ErrorText wrong = refusal_of([&] { b.number("n"); });
  CHECK(wrong.where.field == "a.b[0].n");
  CHECK(wrong.where.line == 1);
  CHECK(wrong.got == "\"x\"");
  CHECK(refusal_of([&] { b.number("m"); }).where.field == "a.b[0].m");
  CHECK(refusal_of([&] { top.integer("i"); }).where.line == 2);
  CHECK_FALSE(top.has("maybe"));
  CHECK(top.choice("which", {"one", "other"}, "one") == "one");
  const ErrorText unknown = refusal_of([&] { top.done(); });
  CHECK_THAT(unknown.what, Contains("unknown field 'u'"));
  CHECK(unknown.expected == "one of a, i, maybe, which");
  CHECK(unknown.where.line == 2);
  CHECK_NOTHROW(top.integer("u"));
  CHECK_NOTHROW(top.done());
}

TEST_CASE("a whole number that no int holds is refused", "[exchange]") {
  const JsonFile file =
      parse_json("{\"a\": 4294967297, \"b\": 18446744073709551615, \"c\": -3}", "f");
  Fields top(file);
  CHECK_THROWS_AS(top.integer("a"), InputError);
  CHECK_THROWS_AS(top.integer("b"), InputError);
  CHECK(top.integer("c") == -3);
}

TEST_CASE("a mechanism goes through JSON without losing a bit", "[exchange]") {
  Random random(7);
  for (int k = 0; k < 200; ++k) {
    Mechanism mechanism = paper_mechanism();
    for (Chain& chain : mechanism.geometry.chains) {
      chain.alpha_rad = rad_from_deg(random.uniform(0, 360));
      chain.beta_rad = rad_from_deg(random.uniform(-180, 180));
      chain.S_mm += random.normal();
      chain.h_mm = random.normal();
      chain.l_zero_mm = random.normal();
    }
    mechanism.home = {1.25, -3, rad_from_deg(random.uniform(-2, 2))};
    const JsonFile file = parse_json(mechanism_json(mechanism).dump(), "m");
    const Mechanism back = read_mechanism(Fields(file));
    CHECK(to_vector(back.geometry) == to_vector(mechanism.geometry));
    CHECK(back.home == mechanism.home);
  }
}

TEST_CASE("a mechanism with a wrong field is refused by its path", "[exchange]") {
  nlohmann::ordered_json json = mechanism_json(paper_mechanism());
  json["chains"][1]["S_mm"] = "430";
  const std::string text = nlohmann::ordered_json{{"mechanism", json}}.dump(1);
  const JsonFile file = parse_json(text, "m.json");
  Fields top(file);
  const ErrorText error = refusal_of([&] { (void)read_mechanism(top.object("mechanism")); });
  CHECK(error.where.field == "mechanism.chains[1].S_mm");
  CHECK(error.where.line > 1);
}
