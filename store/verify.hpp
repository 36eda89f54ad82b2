#pragma once
// Is the file whole, and is what it holds what was stored?

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
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

/// Where a campaign was taken over from an older database.
struct TakenOver {
  int from_version = 0;
  std::string head;  // of its readings' chain there, 64 hexadecimal digits
};
std::optional<TakenOver> taken_head(Connection& connection, std::int64_t campaign_id);

/// Is this (64 hexadecimal digits, as reports print them) the end of the chain of a campaign's
/// readings: now, at an earlier time, or in the older database that it was taken over from?
bool had_head(Connection& connection, std::string_view head);

}  // namespace trammel::store
