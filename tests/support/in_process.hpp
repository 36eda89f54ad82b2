#pragma once
// The program's own entry, called in this process: for what is asked of it hundreds of times. What
// it is as a process, with a folder, signals and a terminal, is asked by program.hpp.

#include "tests/support/program.hpp"

namespace trammel::tests {

/// `trammel WORDS…` in this process and in `folder` (where we are, if empty), its stdout and stderr
/// caught.
Finished run_here(const std::vector<std::string>& words, const std::filesystem::path& folder = {});

}  // namespace trammel::tests
