#include "core/mechanism/geometry.hpp"

#include "core/error.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

TEST_CASE("a geometry survives its parameter vector", "[mechanism]") {
  GeometryVector v;
  for (int k = 0; k < kGeometryParameters; ++k) v[k] = k + 1;
  CHECK(to_vector(from_vector(v)) == v);
  CHECK(geometry_parameters()[7].name == "beta_2");
  CHECK(geometry_parameters()[20].name == "h_3");
}

TEST_CASE("an unusable mechanism is refused by the name of the field", "[mechanism]") {
  Mechanism m = paper_mechanism();
  CHECK_NOTHROW(validate(m));
  m.geometry.chains[1].S_mm = -1;
  CHECK_THROWS_WITH(validate(m), Contains("S_2"));
  m = paper_mechanism();
  m.geometry.chains[2].alpha_rad = NAN;
  CHECK_THROWS_AS(validate(m), InputError);
  m = paper_mechanism();
  m.limits = {300, 200};
  CHECK_THROWS_WITH(validate(m), Contains("l_max_mm"));
}
