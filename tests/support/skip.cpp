#include "tests/support/skip.hpp"

#include <cstdlib>

#include "tests/support/catch.hpp"

namespace trammel::tests {

namespace {
int n_skipped = 0;
}

void skip(const std::string& reason) {
  ++n_skipped;
  WARN("skipped: " << reason);
}

void skip_without(const std::string& program) {
  const char* ci = std::getenv("CI");
  if (ci != nullptr && std::string(ci) == "true") {
    FAIL("CI needs " << program << ", which is not installed: run scripts/setup");
  }
  skip(program + " is not installed: run scripts/setup");
}

int skipped() { return n_skipped; }

}  // namespace trammel::tests
