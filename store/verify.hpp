#pragma once
// Is the file whole, and is what it holds what was stored?

#include <string>
#include <vector>

#include "store/connection.hpp"

namespace trammel::store {

struct CheckReport {
  int n_readings = 0;                 // whose chain was walked
  int n_sealed = 0;                   // other rows that were recomputed
  std::vector<std::string> findings;  // one sentence each; empty: all is well
  [[nodiscard]] bool ok() const { return findings.empty(); }
};

/// SQLite's own checks: pages, indexes, CHECK constraints, foreign keys.
CheckReport check(Connection& connection);

/// check(), and every digest recomputed: the chain of each campaign's readings and the seal of
/// every other row; counts of readings against what attempts and imports promised. Names the rows
/// in which something changed (verify_test.cpp: every byte of the raw rows of a file, one by one).
CheckReport verify(Connection& connection);

}  // namespace trammel::store
