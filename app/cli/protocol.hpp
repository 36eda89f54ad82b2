#pragma once

#include <string>
#include <vector>

#include "app/cli/context.hpp"

namespace trammel::cli {

struct ProtocolOptions {
  std::string file;
  std::vector<std::string> confirmed;  // pauses
  bool record = false;                 // check: write what its steps name
  bool dry_run = false;
};
struct DemoOptions {
  std::string folder = "trammel-demo";
  bool dry_run = false;
};

/// `protocol run FILE`: a whole campaign as data, resumed where an earlier run ended.
void setup_protocol(Command app, Context& context);
ExitCode run_protocol(const ProtocolOptions& options, Context& context);

/// `demo`: the paper's protocol on the virtual robot, into a folder of its own.
void setup_demo(Command app, Context& context);
ExitCode run_demo(const DemoOptions& options, Context& context);

}  // namespace trammel::cli
