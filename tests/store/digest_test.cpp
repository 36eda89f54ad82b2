#include "store/digest.hpp"

#include "tests/support/catch.hpp"

using namespace trammel::store;

TEST_CASE("SHA-256 of nothing is the published value", "[store]") {
  CHECK(hex(Digest().finish()) ==
        "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");  // FIPS 180-4
}

TEST_CASE("values of different types or borders never digest alike", "[store]") {
  const auto of = [](auto... values) {
    Digest digest;
    (digest << ... << values);
    return hex(digest.finish());
  };
  CHECK(of("ab", "c") != of("a", "bc"));
  CHECK(of(1) != of(1.0));
  CHECK(of("") != of(std::nullopt));
  CHECK(of(1.0) != of(1.0 + 1e-15));
  CHECK(of(-0.0) == of(0.0));  // SQLite keeps no sign of zero
}
