#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "app/files/json_file.hpp"

namespace trammel {

/// Takes the fields of one JSON object by name and type. Every error is an InputError with file,
/// line, column and path ("mechanism.chains[1].S_mm"); `done` refuses keys that nobody took.
///
///     Fields top(file);
///     const double lead_mm = top.number("screw_lead_mm", 10.0);
///     for (Fields& chain : top.objects("chains")) { …; chain.done(); }
///     top.done();
///
/// The JsonFile must outlive it.
class Fields {
 public:
  /// The document, which must be an object.
  explicit Fields(const JsonFile& file);

  [[nodiscard]] bool has(std::string_view name);

  // Needed fields throw when missing; with a default they may be absent (but not null).
  double number(std::string_view name);
  double number(std::string_view name, double absent);
  std::optional<double> optional_number(std::string_view name);
  int integer(std::string_view name);
  int integer(std::string_view name, int absent);
  bool boolean(std::string_view name, bool absent);
  std::string text(std::string_view name);
  std::string text(std::string_view name, std::string_view absent);
  std::optional<std::string> optional_text(std::string_view name);
  std::vector<double> numbers(std::string_view name);
  std::vector<std::string> texts(std::string_view name);
  Fields object(std::string_view name);
  std::optional<Fields> optional_object(std::string_view name);
  std::vector<Fields> objects(std::string_view name);
  /// Free keys with text values, as "facts": all that were not taken yet.
  std::vector<std::pair<std::string, std::string>> text_pairs();

  /// One of `allowed`, else an error that lists them.
  std::string choice(std::string_view name, const std::vector<std::string>& allowed);
  std::string choice(std::string_view name, const std::vector<std::string>& allowed,
                     std::string_view absent);

  /// Refuses what nobody asked for.
  void done() const;

  /// An error at field `name` of this object ("" is the object itself).
  [[noreturn]] void refuse(std::string_view name, std::string what, std::string expected = "",
                           std::string hint = "") const;

  /// The path of field `name` from the top of the file.
  [[nodiscard]] std::string path(std::string_view name) const;
  [[nodiscard]] const nlohmann::json& value() const { return *value_; }
  [[nodiscard]] const JsonFile& file() const { return *file_; }

 private:
  Fields(const JsonFile& file, const nlohmann::json& value, std::string path);
  const nlohmann::json& need(std::string_view name);
  const nlohmann::json* find(std::string_view name);

  const JsonFile* file_;
  const nlohmann::json* value_;
  std::string path_;
  std::set<std::string, std::less<>> taken_;
};

}  // namespace trammel
