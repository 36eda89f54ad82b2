#include "store/pages.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <vector>

#include "store/row_name.hpp"

namespace trammel::store {

namespace {

constexpr std::int64_t kLeafOfRows = 0x0D;
constexpr std::int64_t kInnerOfRows = 0x05;
constexpr std::int64_t kInnerOfIndex = 0x02;
constexpr std::int64_t kFileHeaderBytes = 100;  // on page 1
constexpr std::int64_t kLeafHeaderBytes = 8;
constexpr std::int64_t kInnerHeaderBytes = 12;

}  // namespace

Pages::Pages(Connection& connection) : bytes_(nullptr, sqlite3_free) {
  sqlite3_int64 size = 0;
  bytes_.reset(sqlite3_serialize(connection.handle(), "main", &size, 0));
  if (!bytes_ || size < kFileHeaderBytes) return;
  size_ = page_size_ = size;  // until that is read
  page_size_ = number(1, 16, 2) == 1 ? 65536 : number(1, 16, 2);
  if (page_size_ < 512) return;
  try {
    Statement trees(connection,
                    "SELECT tbl_name, iif(type = 'index', name, ''), rootpage FROM sqlite_schema "
                    "WHERE rootpage > 0 UNION ALL SELECT 'sqlite_schema', '', 1");
    while (trees.step()) walk(trees.text(0), trees.text(1), trees.integer(2));
  } catch (const StoreError&) {  // a damaged schema: the trees that it named so far
  }
}

void Pages::walk(const std::string& table, const std::string& index, std::int64_t root) {
  std::vector<std::int64_t> to_do;
  const auto add = [&](std::int64_t page) {
    const bool in_file = page > 0 && page <= size_ / page_size_;
    if (in_file && pages_.emplace(page, Page{table, index}).second) to_do.push_back(page);
  };
  add(root);
  std::int64_t previous_leaf = 0;
  while (!to_do.empty()) {
    const std::int64_t page = to_do.back();
    to_do.pop_back();
    pages_.at(page).previous_leaf = previous_leaf;
    const std::int64_t type = number(page, header(page), 1);
    if (type != kInnerOfRows && type != kInnerOfIndex) {
      previous_leaf = page;
      continue;
    }
    add(number(page, header(page) + kLeafHeaderBytes, 4));  // the rightmost: last of all
    for (std::int64_t cell = cells(page) - 1; cell >= 0; --cell) {
      const std::int64_t at = number(page, header(page) + kInnerHeaderBytes + 2 * cell, 2);
      add(number(page, at, 4));
    }
  }
}

/// Big-endian, at a place on the page; 0 where that ends before it.
std::int64_t Pages::number(std::int64_t page, std::int64_t at, int bytes) const {
  if (at + bytes > page_size_) return 0;
  std::int64_t value = 0;
  for (int k = 0; k < bytes; ++k) {
    value = value << 8 | bytes_.get()[(page - 1) * page_size_ + at + k];
  }
  return value;
}

std::int64_t Pages::header(std::int64_t page) const { return page == 1 ? kFileHeaderBytes : 0; }

std::int64_t Pages::cells(std::int64_t page) const {
  constexpr std::int64_t kLeastCellBytes = 6;  // with its pointer
  return std::min(number(page, header(page) + 3, 2), page_size_ / kLeastCellBytes);
}

/// The number of the row: the second variable-length integer of its cell.
std::optional<Id> Pages::row(std::int64_t page, std::int64_t cell) const {
  if (number(page, header(page), 1) != kLeafOfRows) return std::nullopt;
  if (cell < 0 || cell >= cells(page)) return std::nullopt;
  std::int64_t at = number(page, header(page) + kLeafHeaderBytes + 2 * cell, 2);
  std::uint64_t value = 0;
  for (int integer = 0; integer < 2; ++integer) {
    value = 0;
    for (int k = 0; k < 9; ++k) {
      const auto byte = static_cast<std::uint64_t>(number(page, at++, 1));
      value = k == 8 ? value << 8U | byte : value << 7U | (byte & 0x7FU);
      if (byte < 0x80) break;
    }
  }
  return static_cast<Id>(value);
}

std::string Pages::row_name(const Page& on, std::int64_t page, std::int64_t cell) const {
  const auto id = row(page, cell);
  const bool is_first = cell == 0 && on.previous_leaf == 0;
  std::optional<Id> before;
  if (cell > 0) before = row(page, cell - 1);
  if (cell == 0 && !is_first) before = row(on.previous_leaf, cells(on.previous_leaf) - 1);
  const auto named = [&](Id row) { return on.table + " " + std::to_string(row); };
  if (!id) return before ? on.table + ", after row " + std::to_string(*before) : on.table;
  if (before) return named(*id) + after(*id, *before, named(*before));
  return named(*id) + (is_first ? after(*id, 0, "") : "");
}

std::string Pages::name(std::int64_t page, std::optional<std::int64_t> cell) const {
  const auto found = pages_.find(page);
  if (found == pages_.end()) return "";
  const Page& on = found->second;
  if (!on.index.empty()) return "index " + on.index + " of " + on.table;
  if (number(page, header(page), 1) == kInnerOfRows) return on.table;
  const auto first = row(page, 0), last = row(page, cells(page) - 1);
  if (cell || !first || !last) return row_name(on, page, cell.value_or(0));
  return on.table + ", rows " + std::to_string(*first) + " to " + std::to_string(*last);
}

}  // namespace trammel::store
