#include "app/cli/command_line.hpp"

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>

#include "app/cli/help.hpp"
#include "app/terminal/columns.hpp"

namespace trammel::cli {

namespace {

/// NaN where the word is no number: then no comparison holds.
double number_in(const std::string& word) {
  char* end = nullptr;
  const double value = std::strtod(word.c_str(), &end);
  return end == word.c_str() + word.size() && !word.empty() ? value : std::nan("");
}

std::string shown(const std::string& word) {
  constexpr std::size_t kMost = 40;  // columns: whoever typed more knows it by its beginning
  return terminal::shortened(word, kMost);
}

}  // namespace

// ---------------------------------------------------------------------------------- Option

Option Option::required() const {
  option_->required();
  return *this;
}

Option Option::type(const std::string& name) const {
  option_->type_name(name);
  return *this;
}

Option Option::shown_default() const {
  option_->capture_default_str();
  return *this;
}

Option Option::hide() const {
  option_->group("");
  return *this;
}

Option Option::expected(int n) const {
  option_->expected(n);
  return *this;
}

Option Option::delimiter(char between) const {
  option_->delimiter(between);
  return *this;
}

Option Option::needs(Option other) const {
  option_->needs(other.option_);
  return *this;
}

Option Option::excludes(Option other) const {
  option_->excludes(other.option_);
  return *this;
}

Option Option::one_of(const std::vector<std::string>& words) const {
  option_->check(CLI::IsMember(words));
  return *this;
}

Option Option::range(double low, double high) const {
  option_->check(CLI::Range(low, high));
  return *this;
}

Option Option::range(int low, int high) const {
  option_->check(CLI::Range(low, high));
  return *this;
}

Option Option::range(unsigned low, unsigned high) const {
  option_->check(CLI::Range(low, high));
  return *this;
}

Option Option::positive() const {
  return check([](const std::string& word) {
    return number_in(word) > 0 ? "" : "'" + shown(word) + "' is no number above 0";
  });
}

Option Option::non_negative() const {
  return check([](const std::string& word) {
    return number_in(word) >= 0 ? "" : "'" + shown(word) + "' is no number from 0 on";
  });
}

Option Option::check(std::function<std::string(const std::string&)> fault) const {
  option_->check(CLI::Validator([fault](std::string& word) { return fault(word); }, ""));
  return *this;
}

bool Option::is_required() const { return option_->get_required(); }
bool Option::is_positional() const { return option_->get_positional(); }
bool Option::is_hidden() const { return option_->get_group().empty(); }
bool Option::takes_many() const {
  return option_->get_expected_max() >= CLI::detail::expected_max_vector_size;
}
int Option::expected_min() const { return option_->get_expected_min(); }
int Option::expected_max() const { return option_->get_expected_max(); }
std::string Option::name() const { return option_->get_name(option_->get_positional()); }
std::string Option::all_names() const { return option_->get_name(false, true); }
std::vector<std::string> Option::long_names() const { return option_->get_lnames(); }
bool Option::has_name(const std::string& word) const { return option_->check_name(word); }
std::string Option::description() const { return option_->get_description(); }
std::string Option::type_text() const { return option_->get_type_name(); }
std::string Option::default_text() const { return option_->get_default_str(); }
std::vector<std::string> Option::words() const { return option_->results(); }

namespace {

template <class Handle, class Pointers>
std::vector<Handle> handles(const Pointers& pointers) {
  std::vector<Handle> all;
  for (auto* pointer : pointers) all.emplace_back(*pointer);
  return all;
}

}  // namespace

std::vector<Option> Option::needed() const { return handles<Option>(option_->get_needs()); }
std::vector<Option> Option::excluded() const { return handles<Option>(option_->get_excludes()); }

// --------------------------------------------------------------------------------- Command

Command Command::command(const std::string& name, const std::string& description) const {
  return Command(*app_->add_subcommand(name, description));
}

template <OptionValue T>
Option Command::option(const std::string& name, T& value, const std::string& description) const {
  return Option(*app_->add_option(name, value, description));
}
template Option Command::option(const std::string&, std::string&, const std::string&) const;
template Option Command::option(const std::string&, double&, const std::string&) const;
template Option Command::option(const std::string&, int&, const std::string&) const;
template Option Command::option(const std::string&, unsigned&, const std::string&) const;
template Option Command::option(const std::string&, std::optional<double>&,
                                const std::string&) const;
template Option Command::option(const std::string&, std::optional<int>&, const std::string&) const;
template Option Command::option(const std::string&, std::vector<std::string>&,
                                const std::string&) const;
template Option Command::option(const std::string&, std::vector<double>&, const std::string&) const;

template <OptionValue T>
Option Command::on_option(const std::string& name, std::function<void(const T&)> call,
                          const std::string& description) const {
  return Option(*app_->add_option_function<T>(name, call, description));
}
template Option Command::on_option<int>(const std::string&, std::function<void(const int&)>,
                                        const std::string&) const;
template Option Command::on_option<double>(const std::string&, std::function<void(const double&)>,
                                           const std::string&) const;
template Option Command::on_option<std::vector<double>>(
    const std::string&, std::function<void(const std::vector<double>&)>, const std::string&) const;
template Option Command::on_option<std::vector<std::string>>(
    const std::string&, std::function<void(const std::vector<std::string>&)>,
    const std::string&) const;

Option Command::flag(const std::string& name, bool& value, const std::string& description) const {
  return Option(*app_->add_flag(name, value, description));
}

Option Command::on_flag(const std::string& name, std::function<void()> call,
                        const std::string& description) const {
  return Option(*app_->add_flag_callback(name, std::move(call), description));
}

Command Command::hide() const {
  app_->group("");
  return *this;
}

Command Command::require_command() const {
  app_->require_subcommand(1);
  return *this;
}

void Command::on_chosen(std::function<void()> call) const { app_->callback(std::move(call)); }

std::string Command::name() const { return app_->get_name(); }
std::string Command::description() const { return app_->get_description(); }
bool Command::is_hidden() const { return app_->get_group().empty(); }
bool Command::given(const std::string& option) const { return app_->count(option) > 0; }
std::string Command::help() const { return app_->help(); }

std::optional<Command> Command::parent() const {
  CLI::App* parent = app_->get_parent();
  return parent == nullptr ? std::nullopt : std::optional(Command(*parent));
}

std::vector<Command> Command::commands() const {
  return handles<Command>(app_->get_subcommands([](const CLI::App*) { return true; }));
}

std::optional<Command> Command::chosen() const {
  const auto parsed = app_->get_subcommands();
  return parsed.empty() ? std::nullopt : std::optional(Command(*parsed.front()));
}

std::vector<Option> Command::options() const { return handles<Option>(app_->get_options()); }

std::optional<Option> Command::help_option() const {
  CLI::Option* help = app_->get_help_ptr();
  return help == nullptr ? std::nullopt : std::optional(Option(*help));
}

// ----------------------------------------------------------------------------- CommandLine

namespace {

/// CLI11's order of the parts of a help, each part as help.hpp writes it.
class Formatter final : public CLI::Formatter {
 public:
  Formatter() {
    label("SUBCOMMAND", "COMMAND");
    label("Positionals", "Arguments");
  }
  std::string make_option(const CLI::Option* option, bool as_argument) const override {
    return option_help(handle(option), as_argument);
  }
  std::string make_option_usage(const CLI::Option* option) const override {
    return positional_usage(handle(option));
  }
  std::string make_subcommand(const CLI::App* command) const override {
    return command_help(command->get_name(), command->get_description());
  }
  std::string make_description(const CLI::App* app) const override {
    return description_help(app->get_description());
  }
  std::string make_footer(const CLI::App* app) const override {
    return footer_help(CLI::Formatter::make_footer(app));
  }

 private:
  /// Help reads, and has no handle of its own for that.
  static Option handle(const CLI::Option* option) {
    return Option(const_cast<CLI::Option&>(*option));
  }
};

}  // namespace

CommandLine::CommandLine(const std::string& name) : Command(*new CLI::App("", name)), owned_(app_) {
  app_->formatter(std::make_shared<Formatter>());
  app_->fallthrough();
  app_->require_subcommand(1);
}

CommandLine::~CommandLine() = default;

void CommandLine::describe(const std::string& description, const std::string& footer,
                           const std::string& version) const {
  app_->description(description);
  app_->footer(footer);
  app_->set_version_flag("--version", version, "Print the version and stop");
}

CommandLine::Parsed CommandLine::parse(const std::vector<std::string>& words) const {
  try {
    app_->parse(std::vector<std::string>(words.rbegin(), words.rend()));
  } catch (const CLI::CallForVersion& version) {
    return {Outcome::version_wanted, version.what()};
  } catch (const CLI::CallForHelp&) {
    return {Outcome::help_wanted, ""};
  } catch (const CLI::ParseError& error) {
    return {Outcome::wrong, error.what()};
  }
  return {};
}

}  // namespace trammel::cli
