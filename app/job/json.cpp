#include "app/job/json.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "core/error.hpp"

namespace trammel::job {

namespace {

/// One serializer for all values: Json::dump() makes one anew each time.
class CanonicalWriter {
 public:
  explicit CanonicalWriter(std::string& text)
      : text_(text), serializer_(nlohmann::detail::output_adapter<char>(text), ' ') {}

  void write(const Json& json) {
    if (json.is_object()) return write_object(json.get_ref<const Json::object_t&>());
    if (!json.is_array()) {
      TRAMMEL_ASSERT(!json.is_number_float() || std::isfinite(json.get<double>()));
      return serializer_.dump(json, false, false, 0);
    }
    text_ += '[';
    for (const Json& value : json) {
      if (text_.back() != '[') text_ += ',';
      write(value);
    }
    text_ += ']';
  }

 private:
  void write_object(const Json::object_t& object) {
    std::vector<const Json::object_t::value_type*> members;
    members.reserve(object.size());
    for (const auto& member : object) members.push_back(&member);
    std::ranges::sort(members, {},
                      [](const auto* member) { return std::string_view(member->first); });
    text_ += '{';
    for (const auto* member : members) {
      if (text_.back() != '{') text_ += ',';
      write(member->first);
      text_ += ':';
      write(member->second);
    }
    text_ += '}';
  }

  std::string& text_;
  nlohmann::detail::serializer<Json> serializer_;
};

}  // namespace

std::string canonical_text(const Json& json) {
  std::string text;
  CanonicalWriter(text).write(json);
  return text;
}

}  // namespace trammel::job
