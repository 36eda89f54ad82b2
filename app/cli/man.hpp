#pragma once

#include "app/cli/context.hpp"

namespace trammel::cli {

struct ManOptions {
  const CLI::App* app = nullptr;
};

/// `man`: the manual page, made from the tree of commands.
void setup_man(CLI::App& app, Context& context);
ExitCode run_man(const ManOptions& options, Context& context);

/// trammel(1) as source for groff's man macros. Proof: man_test.cpp (groff -ww finds no fault).
std::string man_page(const CLI::App& app);

}  // namespace trammel::cli
