#include "core/linear/cpu_level.hpp"

#include <sys/utsname.h>

#include <string>

#include "tests/support/catch.hpp"
#include "tests/support/cpu_levels.hpp"

using namespace trammel;

TEST_CASE("the baseline bears the name of the processor it was compiled for", "[linear]") {
  utsname system{};
  REQUIRE(uname(&system) == 0);
  const std::string machine = system.machine;
  const std::string expected = machine == "x86_64"    ? "x86-64"
                               : machine == "aarch64" ? "arm64"
                                                      : "other";
  CHECK(name_of(CpuLevel::x86_64) == expected);
  // No other processor has levels above it.
  CHECK((expected == "x86-64" || cpu_level() == CpuLevel::x86_64));
  CHECK(std::string(name_of(cpu_level())).starts_with(expected));
  CHECK(tests::levels_here().back() == cpu_level());
}
