#include "tests/support/paths.hpp"

namespace trammel::tests {

std::string source_folder() { return TRAMMEL_SOURCE_DIR; }
std::string build_folder() { return TRAMMEL_BINARY_DIR; }

}  // namespace trammel::tests
