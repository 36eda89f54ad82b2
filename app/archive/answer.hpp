#pragma once
// The answer to one question, row by row as it comes.

#include <chrono>

#include "app/archive/link.hpp"

namespace trammel::archive {

/// One row of a result.
Link::Row row_of(const pg_result* result, int row);

/// Holds one row at a time, however long the answer is. The link is of no other use while it lives;
/// an answer that is not asked to its end is ended with the connection. Proof:
/// query_archive_test.cpp
class Link::Answer {
 public:
  /// `limit`: of the whole answer, by the clock of this side, whatever the server does.
  /// @throws InputError  it is not one statement with rows; StoreError: the archive refuses it
  Answer(Link& link, const std::string& sql, std::chrono::milliseconds limit,
         const std::vector<std::string>& values = {});

  [[nodiscard]] const std::vector<std::string>& columns() const { return columns_; }
  /// PostgreSQL's numbers of their types.
  [[nodiscard]] const std::vector<unsigned>& types() const { return types_; }
  /// The next row, or none. @throws StoreError  the time is over
  [[nodiscard]] std::optional<Row> next();

 private:
  struct Clear {
    void operator()(pg_result* result) const;
  };
  void fetch();
  Link& link_;
  std::chrono::steady_clock::time_point deadline_;
  std::unique_ptr<pg_result, Clear> row_;  // none: it has ended
  std::vector<std::string> columns_;
  std::vector<unsigned> types_;
};

}  // namespace trammel::archive
