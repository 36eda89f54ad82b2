#include "app/cli/template.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

namespace trammel::cli {

namespace {

std::string noun_of(const TemplateFile& file) {
  return std::string(file.name.substr(0, file.name.find('.')));
}

/// "galil" of stage.galil.json; "" of robot.json.
std::string kind_of(const TemplateFile& file) {
  const std::size_t first = file.name.find('.'), last = file.name.rfind('.');
  return first == last ? "" : std::string(file.name.substr(first + 1, last - first - 1));
}

std::vector<std::string> template_nouns() {
  std::vector<std::string> nouns;
  for (const TemplateFile& file : template_files()) {
    if (std::ranges::find(nouns, noun_of(file)) == nouns.end()) nouns.push_back(noun_of(file));
  }
  return nouns;
}

std::vector<std::string> kinds_of(const std::string& noun) {
  std::vector<std::string> kinds;
  for (const TemplateFile& file : template_files()) {
    if (noun_of(file) == noun && !kind_of(file).empty()) kinds.push_back(kind_of(file));
  }
  return kinds;
}

const TemplateFile& template_of(const TemplateOptions& o) {
  std::string kind = o.kind;  // XY is xy
  for (char& c : kind) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  for (const TemplateFile& file : template_files()) {
    if (noun_of(file) == o.noun && (kind.empty() || kind_of(file) == kind)) return file;
  }
  const auto kinds = kinds_of(o.noun);
  throw UsageError({.what = fmt::format("there is no {} of this kind", o.noun),
                    .where = {.field = "KIND"},
                    .got = o.kind,
                    .expected = kinds.empty() ? "no kind: there is one template alone"
                                              : fmt::format("one of {}", fmt::join(kinds, ", "))});
}

/// What others call it: robot.json; the readings of campaign.json are readings.csv.
std::string usual_name(const TemplateFile& file) {
  return file.name.ends_with(".csv") ? "readings.csv" : noun_of(file) + ".json";
}

/// What is done with the file, once it is as it should be.
std::string use_of(const TemplateOptions& o, const std::string& out) {
  static const std::map<std::string, std::string> uses = {
      {"machine", "trammel mechanism check {0}"},
      {"robot", "trammel mechanism check {0}"},
      {"campaign", "trammel campaign import . --dry-run"},
      {"layout", "trammel campaign import --points FILE --layout {0} --dry-run"},
      {"protocol", "trammel protocol check {0}"},
      {"plan", "trammel plan check {0} --mechanism {1}"},
      {"stage", "trammel session run CAMPAIGN --plan PLAN --stage galil:{0} --dry-run"},
      {"tracker", "trammel session run CAMPAIGN --plan PLAN --stage STAGE --tracker t2sa:{0}"}};
  const std::filesystem::path robot = std::filesystem::path(out).parent_path() / "robot.json";
  const bool is_there = std::filesystem::exists(robot);
  if (o.noun == "protocol" && !is_there) {
    return fmt::format("trammel template robot{}{} --out {}", o.kind.empty() ? "" : " ", o.kind,
                       shell_word(robot.string()));
  }
  return fmt::format(fmt::runtime(uses.at(o.noun)), shell_word(out),
                     is_there ? shell_word(robot.string()) : "FILE");
}

}  // namespace

ExitCode run_template(const TemplateOptions& options, Context& context) {
  const TemplateFile& file = template_of(options);
  if (context.json) {
    context.print("template", {{"noun", options.noun},
                               {"kind", kind_of(file)},
                               {"kinds", kinds_of(options.noun)},
                               {"file", file.name},
                               {"text", file.text}});
    return ExitCode::ok;
  }
  context.print_as_is(file.text);
  context.next(context.out.empty()
                   ? fmt::format("trammel template {}{}{} --out {}", options.noun,
                                 options.kind.empty() ? "" : " ", options.kind, usual_name(file))
                   : use_of(options, context.out));
  return ExitCode::ok;
}

void setup_template(Command app, Context& context) {
  auto options = std::make_shared<TemplateOptions>();
  Command command = app.command("template", "A commented file to start from, valid as it is");
  command.option("NOUN", options->noun, "of what").required().one_of(template_nouns());
  command.option(
      "KIND", options->kind,
      "machine, robot, plan, protocol: 3-prr, 3-ppr, 3-rpr, xy, x; stage: galil; tracker: t2sa, "
      "file; campaign: readings");
  on_run(command, context, options, run_template);
}

}  // namespace trammel::cli
