#pragma once
// A person's own question: one SELECT, read only, within a time.

#include <chrono>
#include <variant>
#include <vector>

#include "store/statement.hpp"

namespace trammel::store {

using Cell = std::variant<std::nullptr_t, std::int64_t, double, std::string>;  // a blob as hex

/// Of one value in an answer to a SELECT: a job's points of some 200,000 readings.
inline constexpr int kLongestAnsweredBytes = 16 << 20;

/// A table that a program computes.
struct ComputedTable {
  std::string name;
  std::vector<std::string> columns;
  std::vector<std::vector<Cell>> rows;
};

/// Lets questions on this connection, a read-only one, find the table, in place of a view of its
/// name in the file. It is kept in memory and goes with the connection.
void provide(Connection& connection, const ComputedTable& table);

/// Steps through the answer of one statement. The connection must be read-only and is given back
/// when the query goes.
class Query {
 public:
  /// `question` is one SELECT, or the name of a table or view: all of it. In a SELECT values have
  /// at most 16 MB and patterns of LIKE and GLOB at most 1000 bytes: the time limit is looked at
  /// between SQLite's steps, and one step goes through all of a value.
  /// @throws InputError  not one statement that only reads; what SQLite says of it otherwise
  Query(Connection& connection, const std::string& question, std::chrono::milliseconds limit);
  ~Query();
  Query(const Query&) = delete;
  Query& operator=(const Query&) = delete;

  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }
  /// The next row, or none. @throws StoreError  the time is over
  [[nodiscard]] std::optional<std::vector<Cell>> next();

 private:
  Connection& connection_;
  std::chrono::steady_clock::time_point deadline_;
  std::optional<Statement> statement_;
  std::vector<std::string> columns_;
  int longest_value_ = 0, longest_pattern_ = 0;  // of the connection, before
};

}  // namespace trammel::store
