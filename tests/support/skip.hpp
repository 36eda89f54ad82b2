#pragma once
// A case that can't be run here. trammel_tests ends with 77 where all else passed, which ctest
// shows as Skipped.

#include <string>

namespace trammel::tests {

/// What this machine lacks and nobody must have: rights, instructions of its CPU, data of others.
void skip(const std::string& reason);

/// What scripts/setup installs. In CI (the environment has CI=true) it must be there: the case
/// fails.
void skip_without(const std::string& program);

/// Cases skipped so far.
int skipped();

}  // namespace trammel::tests
