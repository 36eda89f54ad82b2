#include "app/cli/commands.hpp"

namespace trammel::cli {

const std::vector<Setup>& commands() {
  static const std::vector<Setup> table = {};
  return table;
}

}  // namespace trammel::cli
