#include "app/cli/context.hpp"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "app/cli/columns.hpp"

namespace trammel::cli {

namespace {

/// Data first where both go to one place.
void write(std::FILE* to, std::string_view text) {
  if (to == stderr) std::fflush(stdout);
  std::fwrite(text.data(), 1, text.size(), to);
  if (text.empty() || text.back() != '\n') std::fputc('\n', to);
}

}  // namespace

std::string Context::db() const {
  if (!db_option.empty()) return db_option;
  const char* from_environment = std::getenv("TRAMMEL_DB");
  if (from_environment != nullptr && *from_environment != '\0') return from_environment;
  return "./trammel.db";
}

bool Context::db_given() const { return db() != "./trammel.db" || !db_option.empty(); }

void Context::print(std::string_view text) const {
  const auto columns = terminal_columns();
  write(stdout, columns ? folded(text, *columns) : std::string(text));
}

void Context::print_as_is(std::string_view text) const { write(stdout, text); }

void Context::print(std::string_view command, const Json& fields) const {
  Json object = {{"schema", "trammel/" + std::string(command) + "/1"}};
  object.update(fields);
  write(stdout, object.dump(2, ' ', false, Json::error_handler_t::replace));
}

void Context::say(std::string_view text) const {
  if (!quiet) write(stderr, text);
}

void Context::next(std::string_view command) const {
  suggested = true;
  if (json || quiet) return;
  write(stderr, "next: " + std::string(command) +
                    (db_option.empty() || command.find(" --db") != std::string_view::npos
                         ? ""
                         : " --db " + shell_word(db_option)));
}

bool colour(int descriptor) {
  const char* no_colour = std::getenv("NO_COLOR");
  if (no_colour != nullptr && *no_colour != '\0') return false;
  return isatty(descriptor) == 1;
}

std::string bold(std::string_view text) {
  if (!colour(STDOUT_FILENO)) return std::string(text);
  return "\x1b[1m" + std::string(text) + "\x1b[0m";
}

std::string printable(std::string_view text) {
  std::string out;
  for (std::size_t k = 0; k < text.size(); ++k) {
    const auto byte = static_cast<unsigned char>(text[k]);
    // C1 controls in UTF-8 are 0xC2 0x80..0x9F: terminals obey them too.
    const bool c1 = byte == 0xC2 && k + 1 < text.size() &&
                    static_cast<unsigned char>(text[k + 1]) >= 0x80 &&
                    static_cast<unsigned char>(text[k + 1]) < 0xA0;
    out += byte < 0x20 || byte == 0x7F || c1 ? '?' : text[k];
    if (c1) ++k;
  }
  return out;
}

std::string shell_word(std::string_view text) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./:@%+=,";
  if (!text.empty() && text.find_first_not_of(kPlain) == std::string_view::npos) {
    return std::string(text);
  }
  std::string quoted = "'";
  for (const char c : printable(text))
    quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

CLI::App& noun(CLI::App& app, const std::string& name, const std::string& description) {
  const auto same = [&name](CLI::App* sub) { return sub->get_name() == name; };
  if (const auto known = app.get_subcommands(same); !known.empty()) return *known.front();
  return *app.add_subcommand(name, description)->require_subcommand(1);
}

}  // namespace trammel::cli
