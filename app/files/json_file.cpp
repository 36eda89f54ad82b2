#include "app/files/json_file.hpp"

#include <vector>

#include "app/files/files.hpp"

namespace trammel {

namespace {

using Json = nlohmann::json;

/// Reads a text and lets the handler see how far the lexer has come.
struct Cursor {
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  const char* at = nullptr;
  std::size_t* n_read = nullptr;

  reference operator*() const { return *at; }
  Cursor& operator++() {
    ++at;
    if (n_read != nullptr) ++*n_read;
    return *this;
  }
  bool operator==(const Cursor& other) const { return at == other.at; }
  bool operator!=(const Cursor& other) const { return at != other.at; }
};

/// Comments blanked, so that every byte stays where it is.
std::string without_comments(std::string_view text) {
  std::string plain(text);
  bool quoted = false;
  for (std::size_t at = 0; at < plain.size(); ++at) {
    if (quoted && plain[at] == '\\') {
      ++at;
    } else if (plain[at] == '"') {
      quoted = !quoted;
    } else if (!quoted && plain.compare(at, 2, "//") == 0) {
      for (; at < plain.size() && plain[at] != '\n' && plain[at] != '\r'; ++at) plain[at] = ' ';
    }
  }
  return plain;
}

/// Lines and columns of growing offsets, each byte looked at once.
class LineCounter {
 public:
  explicit LineCounter(std::string_view text) : text_(text) {}
  JsonFile::Position at(std::size_t offset) {
    for (; offset_ < offset && offset_ < text_.size(); ++offset_) {
      if (text_[offset_] == '\n') {
        ++line_;
        start_ = offset_ + 1;
      }
    }
    return {line_, static_cast<int>(offset_ - start_) + 1};
  }

 private:
  std::string_view text_;
  std::size_t offset_ = 0;
  std::size_t start_ = 0;
  int line_ = 1;
};

/// Builds the tree and notes where each value begins.
class Builder : public nlohmann::json_sax<Json> {
 public:
  Builder(std::string_view text, JsonFile& file, const std::size_t& n_read)
      : text_(text), file_(file), n_read_(n_read), lines_(text) {}

  bool null() override { return add(nullptr); }
  bool boolean(bool value) override { return add(value); }
  bool number_integer(number_integer_t value) override { return add(value); }
  bool number_unsigned(number_unsigned_t value) override { return add(value); }
  bool number_float(number_float_t value, const string_t&) override { return add(value); }
  bool string(string_t& value) override {
    if (value.size() > kMaxJsonTextBytes) {
      refuse("a text of " + std::to_string(value.size()) + " bytes", token(),
             "at most " + std::to_string(kMaxJsonTextBytes));
    }
    return add(std::move(value));
  }
  bool binary(binary_t&) override { return false; }
  bool start_object(std::size_t) override { return open(Json::object()); }
  bool start_array(std::size_t) override { return open(Json::array()); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }

  bool key(string_t& name) override {
    const JsonFile::Position at = token();
    if (open_.back().node->contains(name)) {
      refuse("duplicate key '" + name + "'", at, "each key once");
    }
    key_ = name;
    return true;
  }

  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception& e) override {
    std::string what = e.what();
    if (const auto dash = what.find(" - "); dash != std::string::npos) what.erase(0, dash + 3);
    const std::size_t last = n_read_ > 0 ? n_read_ - 1 : 0;
    refuse("this is no JSON: " + what, lines_.at(last), "");
  }

 private:
  struct Level {
    Json* node;
    std::string path;
  };

  [[noreturn]] void refuse(const std::string& what, JsonFile::Position at,
                           const std::string& expected) const {
    const std::string field = open_.empty() ? "" : open_.back().path;
    throw InputError(
        {.what = what,
         .where = {.file = file_.name, .line = at.line, .column = at.column, .field = field},
         .expected = expected});
  }

  /// Where the token that was just read begins: the first byte since the last event that is not
  /// between tokens.
  JsonFile::Position token() {
    while (last_ < text_.size() &&
           std::string_view(" \t\r\n,:]}").find(text_[last_]) != std::string_view::npos) {
      ++last_;
    }
    const JsonFile::Position at = lines_.at(last_);
    last_ = n_read_;
    return at;
  }

  Json* place(Json value, std::string& path, JsonFile::Position at) {
    Json* placed = put(std::move(value), path);
    if (++n_values_ > kMaxJsonValues) {
      refuse("too many values", at, "at most " + std::to_string(kMaxJsonValues));
    }
    if (path.size() > kMaxJsonPathBytes) {
      refuse("the keys that lead here are too long", at,
             "at most " + std::to_string(kMaxJsonPathBytes) + " bytes together");
    }
    return placed;
  }

  Json* put(Json value, std::string& path) {
    if (open_.empty()) {
      file_.value = std::move(value);
      return &file_.value;
    }
    Json& parent = *open_.back().node;
    path = open_.back().path;
    if (parent.is_array()) {
      path += "[" + std::to_string(parent.size()) + "]";
      return &parent.emplace_back(std::move(value));
    }
    path += (path.empty() ? "" : ".") + key_;
    return &(parent[key_] = std::move(value));
  }

  bool add(Json value) {
    std::string path;
    const JsonFile::Position at = token();
    place(std::move(value), path, at);
    file_.positions.emplace(path, at);
    return true;
  }

  bool open(Json value) {
    const JsonFile::Position at = token();
    if (open_.size() >= static_cast<std::size_t>(kMaxJsonDepth)) {
      refuse("nested too deeply", at, "at most " + std::to_string(kMaxJsonDepth) + " levels");
    }
    std::string path;
    Json* node = place(std::move(value), path, at);
    file_.positions.emplace(path, at);
    open_.push_back({node, path});
    return true;
  }

  bool close() {
    last_ = n_read_;
    open_.pop_back();
    return true;
  }

  std::string_view text_;
  JsonFile& file_;
  const std::size_t& n_read_;
  LineCounter lines_;
  std::vector<Level> open_;
  std::string key_;
  std::size_t last_ = 0;
  std::size_t n_values_ = 0;
};

}  // namespace

Where JsonFile::where(const std::string& path) const {
  Where at{.file = name, .field = path};
  if (const auto found = positions.find(path); found != positions.end()) {
    at.line = found->second.line;
    at.column = found->second.column;
  }
  return at;
}

JsonFile parse_json(std::string_view text, const std::string& name) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  JsonFile file;
  file.name = name;
  std::size_t n_read = 0;
  const std::string plain = without_comments(text);
  Builder builder(plain, file, n_read);
  const Cursor begin{plain.data(), &n_read};
  const Cursor end{plain.data() + plain.size(), nullptr};
  if (!Json::sax_parse(begin, end, &builder)) throw InputError({.what = "this is no JSON"});
  return file;
}

JsonFile read_json(const std::filesystem::path& path) {
  return parse_json(read_file(path, kMaxJsonBytes), path.string());
}

InputError located(const InputError& error, const JsonFile& file) {
  ErrorText text = error.text();
  const std::string field = text.where.field;
  std::string place = field;
  while (!place.empty() && !file.positions.contains(place)) {
    const std::size_t end = place.find_last_of(".[");
    place.resize(end == std::string::npos ? 0 : end);
  }
  const std::string point = text.where.point;
  text.where = file.where(place);
  text.where.field = field;
  text.where.point = point;
  return InputError(text);
}

}  // namespace trammel
