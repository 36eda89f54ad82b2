#include "store/stored_json.hpp"

#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::store;

TEST_CASE("JSON nested deeper than 64 levels is refused where it is read, brackets in text are not",
          "[store]") {
  Connection db(":memory:", Access::create);
  Statement row(db, "SELECT ?, ?, ?");
  row << std::string(64, '[') + std::string(64, ']') << std::string(65, '[')
      << "\"" + std::string(500, '{') + "\\\"[\"";
  REQUIRE(row.step());
  CHECK(stored_json(row, 0).size() == 128);
  CHECK_THROWS_AS(stored_json(row, 1), StoreError);
  CHECK(stored_json(row, 2).size() == 505);
}
