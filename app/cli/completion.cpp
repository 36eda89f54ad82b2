#include "app/cli/completion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>

#include "app/cli/complete.hpp"
#include "app/cli/completion_scripts.hpp"

namespace trammel::cli {

namespace {

struct Shell {
  const char* name;
  std::string_view script;
  const char* read_it;
};
const std::array<Shell, 3>& shells() {
  static const std::array<Shell, 3> all = {
      {{"bash", kBashCompletion, "source <(trammel completion bash)"},
       {"zsh", kZshCompletion, "source <(trammel completion zsh)"},
       {"fish", kFishCompletion, "trammel completion fish | source"}}};
  return all;
}

std::string_view paths_name(Paths paths) {
  constexpr std::array<std::string_view, 3> kNames = {"none", "files", "folders"};
  return kNames.at(static_cast<std::size_t>(paths));
}

}  // namespace

ExitCode run_completion(const CompletionOptions& options, Context& context) {
  const auto* shell = std::ranges::find_if(
      shells(), [&options](const Shell& s) { return s.name == options.shell; });
  if (context.json) {
    context.print("completion", {{"shell", shell->name}, {"script", shell->script}});
  } else {
    context.print_as_is(shell->script);
  }
  context.next(shell->read_it);
  return ExitCode::ok;
}

ExitCode run_complete(const CompleteOptions& options, Context& context) {
  const Candidates found =
      candidates(options.app, options.words, [&context](const auto& name, const auto& given) {
        return stored_values(name, given, context);
      });
  if (context.json) {
    Json words = Json::array();
    for (const Candidate& c : found.words) words.push_back({{"word", c.word}, {"what", c.what}});
    context.print("complete", {{"words", words}, {"paths", paths_name(found.paths)}});
    return ExitCode::ok;
  }
  std::string text;
  for (const Candidate& c : found.words) text += fmt::format("{}\t{}\n", c.word, c.what);
  context.print_as_is(text + fmt::format(":{}", paths_name(found.paths)));
  return ExitCode::ok;
}

void setup_completion(Command app, Context& context) {
  auto script = std::make_shared<CompletionOptions>();
  Command completion = app.command(
      "completion", "Completion at TAB for bash, zsh or fish: prints what the shell reads");
  std::vector<std::string> names;
  for (const Shell& shell : shells()) names.emplace_back(shell.name);
  completion.option("SHELL", script->shell, "bash, zsh or fish").required().one_of(names);
  on_run(completion, context, script, run_completion);

  auto asked = std::make_shared<CompleteOptions>(CompleteOptions{.app = app, .words = {}});
  Command complete =
      app.command("complete", "What can stand next on a command line; used by completions");
  complete.hide();
  complete.option("WORDS", asked->words, "The line behind --, up to the word to complete");
  on_run(complete, context, asked, run_complete);
}

}  // namespace trammel::cli
