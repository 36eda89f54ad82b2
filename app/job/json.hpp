#pragma once
// JSON of jobs: fields keep their order, a number that may be missing is null.

#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace trammel::job {

using Json = nlohmann::ordered_json;

inline Json optional_json(const auto& value) { return value ? Json(*value) : Json(nullptr); }

/// An object with room for so many members: growing copies those that are there, whole.
inline Json object_of(std::size_t members) {
  Json::object_t object;
  object.reserve(members);
  return object;
}

/// The object of names and values in turn.
template <class... NamesAndValues>
Json object_with(NamesAndValues&&... names_and_values) {
  Json::object_t object;
  object.reserve(sizeof...(names_and_values) / 2);
  const auto add = [&object](auto& self, const char* name, auto&& value, auto&&... rest) -> void {
    object.emplace_back(name, std::forward<decltype(value)>(value));
    if constexpr (sizeof...(rest) > 0) self(self, std::forward<decltype(rest)>(rest)...);
  };
  add(add, std::forward<NamesAndValues>(names_and_values)...);
  return object;
}

/// The canonical text (store/job_key.hpp) of a document: keys sorted, no spaces. Every number is
/// finite.
std::string canonical_text(const Json& json);
/// That of a list of numbers, without making a document of it.
std::string canonical_list(std::span<const double> numbers);
std::string canonical_list(std::span<const int> numbers);
/// That of an object, of the canonical texts of its members.
std::string canonical_object(std::vector<std::pair<std::string_view, std::string>> members);

/// The number named `name`; none when it is missing or null.
inline std::optional<double> optional_number(const Json& json, const char* name) {
  return json.contains(name) && json[name].is_number()
             ? std::optional<double>(json[name].get<double>())
             : std::nullopt;
}

}  // namespace trammel::job
