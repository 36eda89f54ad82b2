#include "app/files/positions_file.hpp"

#include "app/files/files.hpp"
#include "app/files/numbers.hpp"
#include "app/files/positions_readers.hpp"
#include "core/error.hpp"

namespace trammel {

std::vector<double> numbers_of(const PointsLine& line, const std::string& name, std::size_t n) {
  const std::vector<PointsCell> cells = points_cells(line.text, ' ');
  std::vector<double> values;
  for (const PointsCell& cell : cells) {
    const auto value = parse_number(cell.text);
    if (!value) {
      throw InputError({.what = "this is no number",
                        .where = {.file = name, .line = line.number, .column = cell.column},
                        .got = std::string(cell.text)});
    }
    values.push_back(*value);
  }
  if (n == 0 || values.size() == n) return values;
  throw InputError({.what = "the row has another number of columns",
                    .where = {.file = name, .line = line.number},
                    .got = std::to_string(values.size()),
                    .expected = std::to_string(n)});
}

PositionsFile parse_positions(std::string text, const std::string& name,
                              const PositionsOptions& options) {
  if (text.find(kAerotechColumns) != std::string::npos) {
    return aerotech_positions(points_text(std::move(text), name), name);
  }
  if (text.find(kRtlRows) != std::string::npos) {
    return rtl_positions(points_text(std::move(text), name), name, options);
  }
  return table_positions(parse_csv(std::move(text), name), options);
}

PositionsFile read_positions(const std::filesystem::path& path, const PositionsOptions& options) {
  return parse_positions(read_file(path, kMaxPositionsBytes), path.string(), options);
}

}  // namespace trammel
