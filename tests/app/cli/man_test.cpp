// The manual page, read as groff and man read it.

#include "app/cli/man.hpp"

#include "app/cli/cli.hpp"
#include "app/cli/command_tree.hpp"
#include "app/cli/commands.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/program.hpp"
#include "tests/support/skip.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using tests::Finished;
using tests::run_command;

namespace {

void check_told(cli::Command command, const std::string& page) {
  for (const cli::Command verb : cli::visible_commands(command)) check_told(verb, page);
  if (!cli::visible_commands(command).empty()) return;
  CAPTURE(cli::full_name(command));
  CHECK_THAT(page, Contains(cli::full_name(command)));
  for (const cli::Option option : cli::options_of(command)) {
    CHECK_THAT(page, Contains("--" + option.long_names().front()));
  }
}

}  // namespace

TEST_CASE("the man page tells every command and option, and groff and man find no fault in it",
          "[cli]") {
  const tests::TemporaryFolder folder;
  const std::string source = tests::run_program({"man", "--quiet"}, folder.path()).out;
  const std::string file = folder.write("trammel.1", source).string();
  const Finished page =
      run_command({"groff", "-man", "-ww", "-Tutf8", "-P-c", file}, folder.path());
  if (page.exit_code == 127) {
    return tests::skip_without("groff");
  }
  CHECK(page.exit_code == 0);
  CHECK(page.err.empty());
  // Without the overstrikes of bold and the breaks of lines, words of the page are those told.
  const Finished plain = run_command(
      {"env", "MANPAGER=cat", "MANWIDTH=500", "man", "--warnings", "-l", file}, folder.path());
  if (plain.exit_code == 127) {
    return tests::skip_without("man");
  }
  CHECK(plain.exit_code == 0);
  CHECK(plain.err.empty());
  std::string text = plain.out;
  for (auto at = text.find("‐"); at != std::string::npos; at = text.find("‐")) {
    text.replace(at, std::string("‐").size(), "-");
  }
  cli::Context context;
  cli::CommandLine app;
  cli::set_up(app, context, cli::commands());
  check_told(app, text);
  CHECK_THAT(text, Contains("EXIT STATUS") && Contains("safety stop") && Contains("TRAMMEL_DB"));
}

TEST_CASE("what looks like a request to groff is text on the man page", "[cli]") {
  cli::CommandLine app;
  app.command("odd", ".so /etc/passwd\n'begin \\fBslash\\fR -- dash … end");
  const std::string page = cli::man_page(app);
  CHECK_THAT(page,
             Contains("\n\\&.so /etc/passwd\n\\&'begin \\efBslash\\efR \\-\\- dash \\[u2026] end"));
}
