#pragma once
// Many rows of one table by few statements.

#include <algorithm>
#include <string>
#include <vector>

#include "store/statement.hpp"

namespace trammel::store {

inline constexpr std::size_t kRowsAStatement = 128;

/// INSERT INTO `table` VALUES (?, ...), (?, ...), ...: `bind(statement, row)` binds a row's
/// `columns`. SQLite keeps for each statement a journal of the pages it may have to undo: the pages
/// that rows share are copied once a statement instead of once a row.
template <class Row, class Bind>
void insert_rows(Connection& connection, const std::string& table, int columns,
                 const std::vector<Row>& rows, const Bind& bind) {
  std::string one = "(?";
  for (int column = 1; column < columns; ++column) one += ",?";
  one += ")";
  for (std::size_t first = 0; first < rows.size(); first += kRowsAStatement) {
    const std::size_t end = std::min(first + kRowsAStatement, rows.size());
    std::string sql = "INSERT INTO " + table + " VALUES " + one;
    for (std::size_t row = first + 1; row < end; ++row) sql.append(",").append(one);
    Statement insert(connection, sql);
    for (std::size_t row = first; row < end; ++row) bind(insert, rows[row]);
    insert.run();
  }
}

}  // namespace trammel::store
