#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "app/cli/context.hpp"

namespace trammel::cli {

/// A file of templates/, compiled in. Each is valid as it stands. Proof: template_test.cpp.
struct TemplateFile {
  std::string_view name;  // "stage.galil.json": of noun "stage", of kind "galil"
  std::string_view text;
};
const std::vector<TemplateFile>& template_files();

struct TemplateOptions {
  std::string noun;
  std::string kind;
};

/// `template NOUN [KIND]`: prints a commented file to start from.
void setup_template(Command app, Context& context);
ExitCode run_template(const TemplateOptions& options, Context& context);

}  // namespace trammel::cli
