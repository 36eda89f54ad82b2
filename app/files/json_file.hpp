#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "core/error.hpp"

namespace trammel {

/// JSON as a user wrote it, with the line and column of every value, so that an error can point.
struct JsonFile {
  struct Position {
    int line = 0;    // from 1
    int column = 0;  // from 1, in bytes
  };

  std::string name;  // the file, as errors show it
  nlohmann::json value;
  std::map<std::string, Position, std::less<>> positions;  // by path: "mechanism.chains[1].S_mm"

  /// File, line, column and field of the value at `path` ("" is the whole document).
  [[nodiscard]] Where where(const std::string& path) const;
};

inline constexpr std::size_t kMaxJsonBytes = 16u << 20;
inline constexpr int kMaxJsonDepth = 64;
inline constexpr std::size_t kMaxJsonValues = 500'000;
inline constexpr std::size_t kMaxJsonTextBytes = 100'000;
inline constexpr std::size_t kMaxJsonPathBytes = 500;  // of all the keys that lead to a value

/// Parses strictly (RFC 8259; no duplicate key, no NaN, no overflow, no more than the caps above),
/// but // to the end of a line is a comment, a blank to us. Throws InputError with line and column.
/// Proof: json_file_test.cpp.
JsonFile parse_json(std::string_view text, const std::string& name);

/// The same for a file. Throws NotFoundError when it is missing.
JsonFile read_json(const std::filesystem::path& path);

/// What core refuses, which names the field alone: with the file, and the line of the field or of
/// the nearest object around it.
InputError located(const InputError& error, const JsonFile& file);

}  // namespace trammel
