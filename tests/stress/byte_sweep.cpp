#include "tests/stress/byte_sweep.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <map>

#include "store/open.hpp"
#include "store/statement.hpp"
#include "tests/support/temporary.hpp"

namespace trammel::test {

namespace {

constexpr unsigned kLeafTable = 0x0D;
constexpr unsigned kInteriorTable = 0x05;
constexpr std::size_t kHeaderBytes = 100;  // of the file, on page 1

unsigned byte_at(const std::string& file, std::size_t at) {
  return static_cast<unsigned char>(file.at(at));
}

std::size_t number_at(const std::string& file, std::size_t at, int bytes) {
  std::size_t value = 0;
  for (int k = 0; k < bytes; ++k)
    value = value << 8U | byte_at(file, at + static_cast<unsigned>(k));
  return value;
}

/// A variable-length integer; `at` moves on behind it.
std::int64_t varint_at(const std::string& file, std::size_t& at) {
  std::uint64_t value = 0;
  for (int k = 0; k < 9; ++k) {
    const unsigned byte = byte_at(file, at++);
    if (k == 8) return static_cast<std::int64_t>(value << 8U | byte);
    value = value << 7U | (byte & 0x7FU);
    if ((byte & 0x80U) == 0) break;
  }
  return static_cast<std::int64_t>(value);
}

/// Where the row that begins at `at` ends; the size of what stays on the page is 1.6's.
Cell cell_at(const std::string& file, std::size_t at, std::size_t usable) {
  Cell cell{.begin = at};
  const auto payload = static_cast<std::size_t>(varint_at(file, at));
  cell.rowid = varint_at(file, at);
  const std::size_t most = usable - 35, least = (usable - 12) * 32 / 255 - 23;
  std::size_t local = payload;
  if (payload > most) {
    local = least + (payload - least) % (usable - 4);
    if (local > most) local = least;
  }
  cell.end = at + local;
  return cell;
}

void walk(const std::string& file, std::size_t page, std::size_t page_size,
          std::vector<Cell>& cells) {
  const std::size_t start = (page - 1) * page_size;
  const std::size_t header = start + (page == 1 ? kHeaderBytes : 0);
  const unsigned type = byte_at(file, header);
  const bool leaf = type == kLeafTable;
  if (!leaf && type != kInteriorTable) return;
  const std::size_t n = number_at(file, header + 3, 2);
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t at = start + number_at(file, header + (leaf ? 8 : 12) + 2 * k, 2);
    if (leaf) {
      cells.push_back(cell_at(file, at, page_size));
    } else {
      walk(file, number_at(file, at, 4), page_size, cells);
    }
  }
  if (!leaf) walk(file, number_at(file, header + 8, 4), page_size, cells);
}

std::string findings_of(const std::filesystem::path& file, const SweepOptions& options) {
  std::string all;
  try {
    store::Connection db = store::open(file, store::Access::read_only);
    for (const std::string& finding : options.look(db).findings) all += finding + "\n";
  } catch (const Error& error) {
    all = error.what();
  }
  return all;
}

/// The words that name each row: "reading 7 (campaign 1, seq 7)" or, of a sealed row, "session 2".
std::map<std::int64_t, std::string> names_of(const std::filesystem::path& file,
                                             const std::string& table) {
  static const std::map<std::string, std::string> sql = {
      {"reading", "SELECT reading_id, 'seq ' || seq || ')' FROM reading"},
      {"point", "SELECT point_id, 'session ' || session_id FROM point"},
      {"machine_chain", "SELECT rowid, 'campaign ' || campaign_id FROM machine_chain"},
      {"drive", "SELECT rowid, 'campaign ' || campaign_id FROM drive"},
      {"campaign_fact", "SELECT rowid, 'campaign ' || campaign_id FROM campaign_fact"}};
  store::Connection db = store::open(file, store::Access::read_only);
  const auto own = sql.find(table);
  store::Statement rows(
      db, own != sql.end() ? own->second : "SELECT rowid, '" + table + " ' || rowid FROM " + table);
  std::map<std::int64_t, std::string> names;
  while (rows.step()) names.emplace(rows.integer(0), rows.text(1));
  return names;
}

/// "attempt 1" is not in "attempt 12", nor in "the row after attempt 1".
bool says(const std::string& findings, const std::string& name) {
  constexpr std::string_view kAfter = "after ";
  for (auto at = findings.find(name); at != findings.npos; at = findings.find(name, at + 1)) {
    const std::size_t end = at + name.size();
    const bool goes_on = end < findings.size() && std::isdigit(findings[end]) != 0;
    const bool is_before = findings.substr(0, at).ends_with(kAfter);
    if (!goes_on && !is_before) return true;
  }
  return false;
}

/// The row by its name or, where the changed byte is in that, by its table and id; as the one
/// before the row that no longer fits; or as the one after the row before.
bool names(const std::string& findings, const std::map<std::int64_t, std::string>& all,
           const std::string& table, std::int64_t rowid) {
  const auto row = all.find(rowid);
  if (row == all.end()) return false;
  if (says(findings, row->second)) return true;
  if (findings.find(table + " " + std::to_string(rowid) + " (") != findings.npos) return true;
  const auto next = std::next(row);
  if (next != all.end() &&
      findings.find(next->second + ": this row, or the one before it") != findings.npos) {
    return true;
  }
  if (row == all.begin()) return findings.find("the first row") != findings.npos;
  return says(findings, "the row after " + table + " " + std::to_string(std::prev(row)->first));
}

std::uint32_t root_of(const std::filesystem::path& file, const std::string& table) {
  store::Connection db = store::open(file, store::Access::read_only);
  store::Statement row(db, "SELECT rootpage FROM sqlite_schema WHERE type = 'table' AND name = ?");
  row << table;
  if (!row.step()) throw std::runtime_error("no table " + table);
  return static_cast<std::uint32_t>(row.integer(0));
}

void put(int descriptor, std::size_t at, char byte) {
  if (::pwrite(descriptor, &byte, 1, static_cast<off_t>(at)) != 1) {
    throw std::runtime_error("pwrite");
  }
}

}  // namespace

std::vector<Cell> rows_of(const std::string& database, std::uint32_t root_page) {
  std::vector<Cell> cells;
  walk(database, root_page, number_at(database, 16, 2), cells);
  return cells;
}

SweepCount sweep_bytes(const std::filesystem::path& file, const SweepOptions& options) {
  SweepCount count{.untouched_is_clean = findings_of(file, options).empty()};
  const auto names_by_row = names_of(file, options.table);
  const std::uint32_t root = root_of(file, options.table);
  const std::string bytes = tests::read_text(file);
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CLOEXEC);
  for (const Cell& cell : rows_of(bytes, root)) {
    ++count.rows;
    for (std::size_t at = cell.begin; at < cell.end; at += static_cast<std::size_t>(options.step)) {
      for (const unsigned char mask : options.masks) {
        put(descriptor, at, static_cast<char>(bytes[at] ^ static_cast<char>(mask)));
        const std::string findings = findings_of(file, options);
        const bool found = !findings.empty(),
                   named = names(findings, names_by_row, options.table, cell.rowid);
        ++count.bytes;
        count.found += found ? 1 : 0;
        count.named += named ? 1 : 0;
        if (!named && count.first_miss.empty()) {
          count.first_miss = options.table + " row " + std::to_string(cell.rowid) + ", byte " +
                             std::to_string(at - cell.begin) + " of " +
                             std::to_string(cell.end - cell.begin) + ": " + findings;
        }
      }
      put(descriptor, at, bytes[at]);
    }
  }
  ::close(descriptor);
  return count;
}

}  // namespace trammel::test
