#pragma once
// The tree of commands and the words of a line. CLI11 stands behind this: its headers cost 6 s in
// each file that includes them, so command_line.cpp alone does.

#include <concepts>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace trammel::cli {

/// What an option can be bound to: the types that command_line.cpp instantiates.
template <class T>
concept OptionValue = std::same_as<T, std::string> || std::same_as<T, double> ||
    std::same_as<T, int> || std::same_as<T, unsigned> || std::same_as<T, std::optional<double>> ||
    std::same_as<T, std::optional<int>> || std::same_as<T, std::vector<std::string>> ||
    std::same_as<T, std::vector<double>>;

/// An option, flag or positional of a command; a handle, as cheap to copy as a pointer.
class Option {
 public:
  explicit Option(CLI::Option& option) : option_(&option) {}
  bool operator==(const Option&) const = default;

  // What it takes. Each returns the option, so that they follow each other.
  Option required() const;
  Option type(const std::string& name) const;  // "FILE": see value_name() of command_tree.hpp
  Option shown_default() const;                // the bound variable's value now
  Option hide() const;                         // from help, completion and man page
  Option expected(int n) const;                // words
  Option delimiter(char between) const;
  Option needs(Option other) const;
  Option excludes(Option other) const;
  Option one_of(const std::vector<std::string>& words) const;
  Option range(double low, double high) const;
  Option range(int low, int high) const;
  Option range(unsigned low, unsigned high) const;
  Option positive() const;
  Option non_negative() const;
  /// `fault` says what is wrong with a word; nothing: empty.
  Option check(std::function<std::string(const std::string& word)> fault) const;

  // What is known of it.
  [[nodiscard]] bool is_required() const;
  [[nodiscard]] bool is_positional() const;
  [[nodiscard]] bool is_hidden() const;
  [[nodiscard]] bool takes_many() const;  // as many words as there are
  [[nodiscard]] int expected_min() const;
  [[nodiscard]] int expected_max() const;  // 0: a flag
  [[nodiscard]] std::string name() const;  // "--db"; a positional's without dashes
  [[nodiscard]] std::string all_names() const;
  [[nodiscard]] std::vector<std::string> long_names() const;  // without dashes
  [[nodiscard]] bool has_name(const std::string& word) const;
  [[nodiscard]] std::string description() const;
  [[nodiscard]] std::string type_text() const;  // with what its checks add: "TEXT:{a,b}"
  [[nodiscard]] std::string default_text() const;
  [[nodiscard]] std::vector<Option> needed() const;
  [[nodiscard]] std::vector<Option> excluded() const;
  [[nodiscard]] std::vector<std::string> words() const;  // that the parsed line gave

 private:
  CLI::Option* option_;
};

/// A command, noun or verb; a handle, as Option. It lives as long as its CommandLine.
class Command {
 public:
  explicit Command(CLI::App& app) : app_(&app) {}

  /// A new one below it.
  Command command(const std::string& name, const std::string& description) const;

  /// Options write to `value` when the line is parsed.
  template <OptionValue T>
  Option option(const std::string& name, T& value, const std::string& description) const;
  Option flag(const std::string& name, bool& value, const std::string& description) const;

  /// Options that call.
  template <OptionValue T>
  Option on_option(const std::string& name, std::function<void(const T&)> call,
                   const std::string& description) const;
  Option on_flag(const std::string& name, std::function<void()> call,
                 const std::string& description) const;

  Command hide() const;
  Command require_command() const;  // a line that names it names one below it
  void on_chosen(std::function<void()> call) const;

  [[nodiscard]] std::string name() const;
  [[nodiscard]] std::string description() const;
  [[nodiscard]] bool is_hidden() const;
  [[nodiscard]] std::optional<Command> parent() const;
  [[nodiscard]] std::vector<Command> commands() const;  // hidden ones too
  [[nodiscard]] std::optional<Command> chosen() const;  // the one below it that the line named
  [[nodiscard]] std::vector<Option> options() const;    // positionals too
  [[nodiscard]] std::optional<Option> help_option() const;
  [[nodiscard]] bool given(const std::string& option) const;  // on the parsed line
  [[nodiscard]] std::string help() const;                     // of what the line named

 protected:
  CLI::App* app_;
};

/// The program itself, and the owner of the tree.
class CommandLine : public Command {
 public:
  explicit CommandLine(const std::string& name = "trammel");
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  /// What help shows above and below the commands, and the answer to --version. Before commands
  /// are added: they inherit it.
  void describe(const std::string& description, const std::string& footer,
                const std::string& version) const;

  enum class Outcome { ok, help_wanted, version_wanted, wrong };
  struct Parsed {
    Outcome outcome = Outcome::ok;
    std::string text;  // the version, or what is wrong
  };
  /// Sets what options are bound to and calls what they and the chosen command call.
  [[nodiscard]] Parsed parse(const std::vector<std::string>& words) const;

 private:
  std::unique_ptr<CLI::App> owned_;
};

}  // namespace trammel::cli
