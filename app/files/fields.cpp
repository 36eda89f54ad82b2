#include "app/files/fields.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "app/files/format.hpp"

namespace trammel {

namespace {

using Json = nlohmann::json;

std::string shown(const Json& value) {
  std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (text.size() > 40) text = text.substr(0, 37) + "...";
  return text;
}

[[noreturn]] void wrong(const JsonFile& file, const std::string& path, const Json& value,
                        const std::string& expected) {
  throw InputError({.what = "wrong type or value",
                    .where = file.where(path),
                    .got = shown(value),
                    .expected = expected});
}

double as_number(const JsonFile& file, const std::string& path, const Json& value) {
  if (!value.is_number()) wrong(file, path, value, "a number");
  const double number = value.get<double>();
  if (!(std::abs(number) <= kLargestNumber)) {
    wrong(file, path, value, "a number of a size that a laboratory has");
  }
  return number;
}

int as_integer(const JsonFile& file, const std::string& path, const Json& value) {
  const bool fits = value.is_number_integer() &&
                    (!value.is_number_unsigned() ||
                     value.get<std::uint64_t>() <= std::numeric_limits<int>::max()) &&
                    value.get<std::int64_t>() >= std::numeric_limits<int>::min();
  if (!fits) wrong(file, path, value, "a whole number");
  return value.get<int>();
}

const std::string& as_text(const JsonFile& file, const std::string& path, const Json& value) {
  if (!value.is_string()) wrong(file, path, value, "a text");
  return value.get_ref<const std::string&>();
}

}  // namespace

Fields::Fields(const JsonFile& file) : Fields(file, file.value, "") {}

Fields::Fields(const JsonFile& file, const Json& value, std::string path)
    : file_(&file), value_(&value), path_(std::move(path)) {
  if (!value.is_object()) wrong(file, path_, value, "an object {…}");
}

std::string Fields::path(std::string_view name) const {
  if (name.empty()) return path_;
  return path_.empty() ? std::string(name) : path_ + "." + std::string(name);
}

bool Fields::has(std::string_view name) { return find(name) != nullptr; }

const Json* Fields::find(std::string_view name) {
  taken_.emplace(name);
  const auto at = value_->find(std::string(name));
  return at == value_->end() ? nullptr : &*at;
}

const Json& Fields::need(std::string_view name) {
  if (const Json* value = find(name)) return *value;
  throw InputError({.what = "the field '" + std::string(name) + "' is missing", .where = [&] {
                      Where at = file_->where(path_);
                      at.field = path(name);
                      return at;
                    }()});
}

double Fields::number(std::string_view name) { return as_number(*file_, path(name), need(name)); }

double Fields::number(std::string_view name, double absent) {
  return optional_number(name).value_or(absent);
}

std::optional<double> Fields::optional_number(std::string_view name) {
  const Json* value = find(name);
  if (value == nullptr) return std::nullopt;
  return as_number(*file_, path(name), *value);
}

int Fields::integer(std::string_view name) { return as_integer(*file_, path(name), need(name)); }

int Fields::integer(std::string_view name, int absent) {
  const Json* value = find(name);
  return value == nullptr ? absent : as_integer(*file_, path(name), *value);
}

bool Fields::boolean(std::string_view name, bool absent) {
  const Json* value = find(name);
  if (value == nullptr) return absent;
  if (!value->is_boolean()) wrong(*file_, path(name), *value, "true or false");
  return value->get<bool>();
}

std::string Fields::text(std::string_view name) { return as_text(*file_, path(name), need(name)); }

std::string Fields::text(std::string_view name, std::string_view absent) {
  return optional_text(name).value_or(std::string(absent));
}

std::optional<std::string> Fields::optional_text(std::string_view name) {
  const Json* value = find(name);
  if (value == nullptr) return std::nullopt;
  return as_text(*file_, path(name), *value);
}

std::vector<double> Fields::numbers(std::string_view name) {
  const Json& array = need(name);
  if (!array.is_array()) wrong(*file_, path(name), array, "a list of numbers");
  std::vector<double> values;
  for (const Json& value : array) {
    values.push_back(
        as_number(*file_, path(name) + "[" + std::to_string(values.size()) + "]", value));
  }
  return values;
}

std::vector<std::string> Fields::texts(std::string_view name) {
  const Json& array = need(name);
  if (!array.is_array()) wrong(*file_, path(name), array, "a list of texts");
  std::vector<std::string> values;
  for (const Json& value : array) {
    values.push_back(
        as_text(*file_, path(name) + "[" + std::to_string(values.size()) + "]", value));
  }
  return values;
}

Fields Fields::object(std::string_view name) { return {*file_, need(name), path(name)}; }

std::optional<Fields> Fields::optional_object(std::string_view name) {
  const Json* value = find(name);
  if (value == nullptr) return std::nullopt;
  return Fields(*file_, *value, path(name));
}

std::vector<Fields> Fields::objects(std::string_view name) {
  const Json& array = need(name);
  if (!array.is_array()) wrong(*file_, path(name), array, "a list of objects");
  std::vector<Fields> objects;
  for (const Json& value : array) {
    objects.push_back(
        Fields(*file_, value, path(name) + "[" + std::to_string(objects.size()) + "]"));
  }
  return objects;
}

std::vector<std::pair<std::string, std::string>> Fields::text_pairs() {
  std::vector<std::pair<std::string, std::string>> pairs;
  for (const auto& [name, value] : value_->items()) {
    if (!taken_.insert(name).second) continue;
    pairs.emplace_back(name, as_text(*file_, path(name), value));
  }
  return pairs;
}

std::string Fields::choice(std::string_view name, const std::vector<std::string>& allowed) {
  const std::string value = text(name);
  if (std::find(allowed.begin(), allowed.end(), value) != allowed.end()) return value;
  std::string expected;
  for (const std::string& word : allowed) expected += (expected.empty() ? "" : ", ") + word;
  wrong(*file_, path(name), Json(value), "one of " + expected);
}

std::string Fields::choice(std::string_view name, const std::vector<std::string>& allowed,
                           std::string_view absent) {
  return has(name) ? choice(name, allowed) : std::string(absent);
}

void Fields::done() const {
  for (const auto& [name, value] : value_->items()) {
    if (taken_.contains(name)) continue;
    std::string known;
    for (const std::string& word : taken_) known += (known.empty() ? "" : ", ") + word;
    throw InputError({.what = "unknown field '" + name + "'",
                      .where = file_->where(path(name)),
                      .expected = known.empty() ? "no field here" : "one of " + known});
  }
}

void Fields::refuse(std::string_view name, std::string what, std::string expected,
                    std::string hint) const {
  ErrorText text{.what = std::move(what),
                 .where = file_->where(path(name)),
                 .expected = std::move(expected),
                 .hint = std::move(hint)};
  const auto at = value_->find(std::string(name));
  if (at != value_->end()) text.got = shown(*at);
  throw InputError(std::move(text));
}

}  // namespace trammel
