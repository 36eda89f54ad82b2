#pragma once
// Every byte of every stored row of a table changed, one at a time: does `db verify` see it?

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "store/verify.hpp"

namespace trammel::test {

/// A row's bytes in the file: sizes, rowid and record.
struct Cell {
  std::int64_t rowid = 0;
  std::size_t begin = 0;
  std::size_t end = 0;
};

/// The rows of a table in the bytes of a database without a log, read by the file format alone
/// (sqlite.org/fileformat2.html, 1.5 and 1.6). A row that continues on overflow pages ends where
/// those begin.
std::vector<Cell> rows_of(const std::string& database, std::uint32_t root_page);

struct SweepOptions {
  std::string table = "reading";
  std::vector<unsigned char> masks = {0x01};  // each byte is xor-ed with each of these
  int step = 1;                               // every so many bytes
  std::function<store::CheckReport(store::Connection&)> look = store::verify;
};

struct SweepCount {
  int rows = 0;
  int bytes = 0;  // that were changed, one at a time
  int found = 0;
  int named = 0;  // the findings name the row, or say that it is the one after the row before
  bool untouched_is_clean = false;  // the control: verify finds nothing in the file as it was
  std::string first_miss = {};      // what was not found or not named
};

/// Changes `file` in place and puts each byte back. Tables: reading, and those of sealed rows.
SweepCount sweep_bytes(const std::filesystem::path& file, const SweepOptions& options);

}  // namespace trammel::test
