#include "app/cli/margins.hpp"

namespace trammel::cli {

void margin_options(Command command, CheckOptions& check) {
  const auto option = [&](const char* name, double& value, const char* what) {
    command.option(name, value, what).shown_default();
  };
  option("--limit-margin", check.limit_margin_mm, "free stroke, mm");
  option("--singularity-margin", check.singularity_margin, "0 to 1");
  option("--link-clearance", check.link_clearance_mm,
         "between centre lines of links, and of a link and the platform, mm");
  option("--max-speed", check.max_speed_mm_s, "of a drive, mm/s: a faster stage is refused");
  option("--max-platform-speed", check.max_platform_mm_s, "of the reflector on the way, mm/s");
}

}  // namespace trammel::cli
