#include "app/job/json.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <vector>

#include "core/error.hpp"

namespace trammel::job {

namespace {

/// As Json::dump() with sorted keys, without asking the output for each letter and number by itself
/// or making a serializer anew for each value.
class CanonicalWriter {
 public:
  explicit CanonicalWriter(std::string& text)
      : text_(text), serializer_(nlohmann::detail::output_adapter<char>(text), ' ') {}

  void write(const Json& json) {
    if (json.is_object()) return write_object(json.get_ref<const Json::object_t&>());
    if (json.is_number_float()) return write(json.get<double>());
    if (json.is_string()) return write_text(json.get_ref<const std::string&>());
    if (!json.is_array()) return serializer_.dump(json, false, false, 0);
    text_ += '[';
    for (const Json& value : json) {
      if (text_.back() != '[') text_ += ',';
      write(value);
    }
    text_ += ']';
  }

  void write(double value) {
    TRAMMEL_ASSERT(std::isfinite(value));
    std::array<char, 64> digits{};
    char* const begin = digits.data();
    text_.append(begin, nlohmann::detail::to_chars(begin, begin + digits.size(), value));
  }
  void write(int value) { text_ += std::to_string(value); }

 private:
  void write_text(const std::string& text) {
    const auto plain = [](char c) { return c >= ' ' && c != '"' && c != '\\'; };  // and ASCII
    if (!std::ranges::all_of(text, plain)) return serializer_.dump(text, false, false, 0);
    text_.append(1, '"').append(text).append(1, '"');
  }

  void write_object(const Json::object_t& object) {
    std::vector<const Json::object_t::value_type*> members;
    members.reserve(object.size());
    for (const auto& member : object) members.push_back(&member);
    std::ranges::sort(members, {},
                      [](const auto* member) { return std::string_view(member->first); });
    text_ += '{';
    for (const auto* member : members) {
      if (text_.back() != '{') text_ += ',';
      write_text(member->first);
      text_ += ':';
      write(member->second);
    }
    text_ += '}';
  }

  std::string& text_;
  nlohmann::detail::serializer<Json> serializer_;
};

template <class Number>
std::string list_text(std::span<const Number> numbers) {
  constexpr std::size_t kLongest = 25;  // -2.2250738585072014e-308,
  std::string text = "[";
  text.reserve(kLongest * numbers.size() + 2);
  CanonicalWriter writer(text);
  for (const Number number : numbers) {
    if (text.back() != '[') text += ',';
    writer.write(number);
  }
  return text + ']';
}

}  // namespace

std::string canonical_text(const Json& json) {
  std::string text;
  text.reserve(1U << 12U);
  CanonicalWriter(text).write(json);
  return text;
}

std::string canonical_list(std::span<const double> numbers) { return list_text(numbers); }
std::string canonical_list(std::span<const int> numbers) { return list_text(numbers); }

std::string canonical_object(std::vector<std::pair<std::string_view, std::string>> members) {
  std::ranges::sort(members);
  std::string text = "{";
  std::size_t size = 2;
  for (const auto& [name, value] : members) size += name.size() + value.size() + 4;
  text.reserve(size);
  for (const auto& [name, value] : members) {
    if (text.back() != '{') text += ',';
    text.append(1, '"').append(name).append("\":").append(value);
  }
  return text + '}';
}

}  // namespace trammel::job
