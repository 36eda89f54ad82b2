#pragma once
// Which rows stand on a page of the file: SQLite names damage by pages, a person by rows.

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "store/statement.hpp"

namespace trammel::store {

/// The trees of the file by its format (sqlite.org/fileformat2.html, 1.6), from a copy of its pages
/// in memory as SQLite reads them, its log among them. Whatever the bytes are: each page is
/// looked at once, and nothing beyond it.
class Pages {
 public:
  explicit Pages(Connection& connection);

  /// "attempt 10" or "attempt 138, the row after attempt 9", the row of a cell; "attempt, rows 1 to
  /// 12", those of a page; "index … of attempt"; only the table, where the page can't be read, or
  /// leads to others; nothing, of a page in no tree.
  [[nodiscard]] std::string name(std::int64_t page, std::optional<std::int64_t> cell) const;

 private:
  struct Page {
    std::string table;
    std::string index;
    std::int64_t previous_leaf = 0;
  };
  void walk(const std::string& table, const std::string& index, std::int64_t root);
  [[nodiscard]] std::int64_t number(std::int64_t page, std::int64_t at, int bytes) const;
  [[nodiscard]] std::int64_t header(std::int64_t page) const;
  [[nodiscard]] std::int64_t cells(std::int64_t page) const;
  [[nodiscard]] std::string row_name(const Page& on, std::int64_t page, std::int64_t cell) const;
  [[nodiscard]] std::optional<Id> row(std::int64_t page, std::int64_t cell) const;

  std::unique_ptr<unsigned char, void (*)(void*)> bytes_;
  std::int64_t size_ = 0;
  std::int64_t page_size_ = 0;
  std::map<std::int64_t, Page> pages_;
};

}  // namespace trammel::store
