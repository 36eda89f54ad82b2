#define CATCH_CONFIG_RUNNER
#include <catch2/catch.hpp>

#include "app/allocator.hpp"
#include "tests/support/skip.hpp"

int main(int argc, char** argv) {
  constexpr int kSkipped = 77;  // of ctest's SKIP_RETURN_CODE, only where nothing failed
  trammel::keep_freed_memory();
  const int n_failed = Catch::Session().run(argc, argv);
  return n_failed == 0 && trammel::tests::skipped() > 0 ? kSkipped : n_failed;
}
