#include "app/job/json.hpp"

#include <algorithm>
#include <vector>

namespace trammel::job {

namespace {

void append(const Json& json, std::string& text);

void append_object(const Json& json, std::string& text) {
  std::vector<Json::const_iterator> members;
  members.reserve(json.size());
  for (auto member = json.begin(); member != json.end(); ++member) members.push_back(member);
  std::ranges::sort(members, {}, [](const auto& member) { return std::string_view(member.key()); });
  text += '{';
  for (const auto& member : members) {
    if (text.back() != '{') text += ',';
    text += Json(member.key()).dump();
    text += ':';
    append(*member, text);
  }
  text += '}';
}

void append(const Json& json, std::string& text) {
  if (json.is_object()) return append_object(json, text);
  if (!json.is_array()) {
    text += json.dump();
    return;
  }
  text += '[';
  for (const Json& value : json) {
    if (text.back() != '[') text += ',';
    append(value, text);
  }
  text += ']';
}

}  // namespace

std::string canonical_text(const Json& json) {
  std::string text;
  append(json, text);
  return text;
}

}  // namespace trammel::job
