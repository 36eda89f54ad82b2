#include "app/cli/context.hpp"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "app/cli/command_tree.hpp"
#include "app/terminal/columns.hpp"
#include "app/terminal/typable.hpp"

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

void Context::print(std::string_view text) const {
  const auto columns = terminal_columns();
  write(stdout, columns ? folded(text, *columns) : std::string(text));
}

void Context::print_as_is(std::string_view text) const {
  write(stdout, ::isatty(STDOUT_FILENO) == 1 ? printable(text, "\n\t") : std::string(text));
}

void Context::print(std::string_view command, const Json& fields) const {
  Json object = {{"schema", "trammel/" + std::string(command) + "/1"}};
  object.update(fields);
  write(stdout, printable_json(object.dump(2, ' ', false, Json::error_handler_t::replace)));
}

void Context::say(std::string_view text) const {
  if (quiet) return;
  const auto columns = terminal_columns(STDERR_FILENO);
  write(stderr, columns ? folded(text, *columns) : std::string(text));
}

void Context::next(std::string_view command) const {
  suggested = true;
  if (!json && !quiet) write(stderr, "next: " + of_the_same(command));
}

std::string Context::of_the_same(std::string_view command) const {
  std::string line(command);
  const auto has = [&line](const char* words) { return line.find(words) != std::string::npos; };
  const bool of_a_plan = has("trammel plan check ") || has("trammel plan create ");
  if (!machine.empty() && of_a_plan && !has(" --mechanism ") && !has(" --campaign ")) {
    line += " --mechanism " + shell_word(machine);
  }
  if (!db_option.empty() && has("trammel ") && !has(" --db ") && !has(" | ")) {
    line += " --db " + shell_word(db_option);
  }
  return typable(line);
}

Command noun(Command app, const std::string& name, const std::string& description) {
  if (const auto known = find_command(app, name)) return *known;
  return app.command(name, description).require_command();
}

void on_run(Command command, Context& context, std::function<ExitCode()> run) {
  command.on_chosen([&context, run = std::move(run)] { context.chosen = run; });
}

}  // namespace trammel::cli
